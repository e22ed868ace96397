// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/mcap_writer.h"

#include <algorithm>

#include <glog/logging.h>

namespace prism {
namespace {

constexpr char kMagic[] = "\x89MCAP0\r\n";
constexpr size_t kMagicSize = 8;
constexpr size_t kChunkSize = 1 << 22;  // bytes, about

enum Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

// Little-endian on any machine.
template <typename T>
void Put(T value, std::string* bytes) {
  for (size_t i = 0; i < sizeof(T); ++i) {
    bytes->push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i) & 0xff));
  }
}

void PutText(const std::string& text, std::string* bytes) {
  Put(static_cast<uint32_t>(text.size()), bytes);
  *bytes += text;
}

std::string Record(Opcode opcode, const std::string& contents) {
  std::string record;
  Put(static_cast<uint8_t>(opcode), &record);
  Put(static_cast<uint64_t>(contents.size()), &record);
  return record + contents;
}

}  // namespace

McapWriter::McapWriter() : file_(kMagic, kMagicSize) {
  std::string header;
  PutText("", &header);  // no profile
  PutText("PRISM-VO", &header);
  file_ += Record(kHeader, header);
}

uint16_t McapWriter::AddSchema(const std::string& name, const std::string& descriptor_set) {
  std::string schema;
  Put(++schema_count_, &schema);
  PutText(name, &schema);
  PutText("protobuf", &schema);
  PutText(descriptor_set, &schema);
  schemas_ += Record(kSchema, schema);
  return schema_count_;
}

uint16_t McapWriter::AddChannel(uint16_t schema, const std::string& topic) {
  const auto id = static_cast<uint16_t>(channel_records_.size());
  std::string channel;
  Put(id, &channel);
  Put(schema, &channel);
  PutText(topic, &channel);
  PutText("protobuf", &channel);
  Put(uint32_t{0}, &channel);  // no metadata
  channel_records_[id] = Record(kChannel, channel);
  message_counts_[id] = 0;
  return id;
}

void McapWriter::AddMessage(uint16_t channel, int64_t time_ns, const std::string& data) {
  CHECK_GE(time_ns, 0);
  CHECK_GT(channel_records_.count(channel), 0u);
  const auto time = static_cast<uint64_t>(time_ns);
  if (chunk_.empty()) {
    // Each chunk stands for itself: it brings what its messages are.
    chunk_ = schemas_;
    for (const auto& [id, record] : channel_records_) chunk_ += record;
    chunk_first_ns_ = chunk_last_ns_ = time;
  }
  chunk_first_ns_ = std::min(chunk_first_ns_, time);
  chunk_last_ns_ = std::max(chunk_last_ns_, time);
  first_ns_ = message_count_ == 0 ? time : std::min(first_ns_, time);
  last_ns_ = std::max(last_ns_, time);
  chunk_messages_[channel].emplace_back(time, chunk_.size());
  std::string message;
  Put(channel, &message);
  Put(static_cast<uint32_t>(message_counts_[channel]), &message);
  Put(time, &message);  // logged
  Put(time, &message);  // published
  chunk_ += Record(kMessage, message + data);
  ++message_counts_[channel];
  ++message_count_;
  if (chunk_.size() > kChunkSize) FinishChunk();
}

void McapWriter::FinishChunk() {
  if (chunk_.empty()) return;
  std::string chunk;
  Put(chunk_first_ns_, &chunk);
  Put(chunk_last_ns_, &chunk);
  Put(static_cast<uint64_t>(chunk_.size()), &chunk);
  Put(uint32_t{0}, &chunk);
  PutText("", &chunk);  // not compressed
  Put(static_cast<uint64_t>(chunk_.size()), &chunk);
  const std::string record = Record(kChunk, chunk + chunk_);
  ChunkIndex index = {
      chunk_first_ns_, chunk_last_ns_, file_.size(), record.size(), 0, chunk_.size(), {}};
  file_ += record;
  const size_t indexes_start = file_.size();
  for (auto& [channel, messages] : chunk_messages_) {
    index.index_offsets[channel] = file_.size();
    std::sort(messages.begin(), messages.end());
    std::string entries;
    Put(channel, &entries);
    Put(static_cast<uint32_t>(16 * messages.size()), &entries);
    for (const auto& [time, offset] : messages) {
      Put(time, &entries);
      Put(offset, &entries);
    }
    file_ += Record(kMessageIndex, entries);
  }
  index.index_length = file_.size() - indexes_start;
  chunks_.push_back(index);
  chunk_.clear();
  chunk_messages_.clear();
}

std::string McapWriter::Finish() {
  FinishChunk();
  std::string data_end;
  Put(uint32_t{0}, &data_end);
  file_ += Record(kDataEnd, data_end);

  const uint64_t summary_start = file_.size();
  std::string offsets;
  const auto add_group = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    std::string offset;
    Put(static_cast<uint8_t>(opcode), &offset);
    Put(static_cast<uint64_t>(file_.size()), &offset);
    Put(static_cast<uint64_t>(records.size()), &offset);
    offsets += Record(kSummaryOffset, offset);
    file_ += records;
  };
  add_group(kSchema, schemas_);
  for (const auto& [id, record] : channel_records_) channels_ += record;
  add_group(kChannel, channels_);
  std::string statistics;
  Put(message_count_, &statistics);
  Put(schema_count_, &statistics);
  Put(static_cast<uint32_t>(channel_records_.size()), &statistics);
  Put(uint32_t{0}, &statistics);  // attachments
  Put(uint32_t{0}, &statistics);  // metadata
  Put(static_cast<uint32_t>(chunks_.size()), &statistics);
  Put(first_ns_, &statistics);
  Put(last_ns_, &statistics);
  Put(static_cast<uint32_t>(10 * message_counts_.size()), &statistics);
  for (const auto& [channel, count] : message_counts_) {
    Put(channel, &statistics);
    Put(count, &statistics);
  }
  add_group(kStatistics, Record(kStatistics, statistics));
  std::string indexes;
  for (const ChunkIndex& chunk : chunks_) {
    std::string index;
    Put(chunk.first_ns, &index);
    Put(chunk.last_ns, &index);
    Put(chunk.offset, &index);
    Put(chunk.length, &index);
    Put(static_cast<uint32_t>(10 * chunk.index_offsets.size()), &index);
    for (const auto& [channel, offset] : chunk.index_offsets) {
      Put(channel, &index);
      Put(offset, &index);
    }
    Put(chunk.index_length, &index);
    PutText("", &index);
    Put(chunk.size, &index);
    Put(chunk.size, &index);
    indexes += Record(kChunkIndex, index);
  }
  add_group(kChunkIndex, indexes);
  const uint64_t offsets_start = file_.size();
  file_ += offsets;
  std::string footer;
  Put(summary_start, &footer);
  Put(offsets_start, &footer);
  Put(uint32_t{0}, &footer);
  file_ += Record(kFooter, footer);
  file_.append(kMagic, kMagicSize);
  return std::move(file_);
}

}  // namespace prism
