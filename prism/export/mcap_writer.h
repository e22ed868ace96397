// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace prism {

// An MCAP file (https://mcap.dev/spec) in memory: chunks without compression, with message indexes
// and a summary, so that readers find what they look for without reading all. Check sums are left
// out (0), which the format allows.
class McapWriter {
 public:
  McapWriter();

  // A protobuf message type, `descriptor_set` a serialised FileDescriptorSet. Ids begin at 1.
  uint16_t AddSchema(const std::string& name, const std::string& descriptor_set);
  // Channels begin at 0.
  uint16_t AddChannel(uint16_t schema, const std::string& topic);
  // Precondition: time_ns >= 0.
  void AddMessage(uint16_t channel, int64_t time_ns, const std::string& data);

  // The whole file. Nothing may be added afterwards.
  std::string Finish();

 private:
  struct ChunkIndex {
    uint64_t first_ns, last_ns, offset, length, index_length, size;
    std::map<uint16_t, uint64_t> index_offsets;  // of each channel
  };

  void FinishChunk();

  std::string file_;
  std::string chunk_;
  std::string schemas_, channels_;  // records, repeated in the summary
  std::map<uint16_t, std::string> channel_records_;
  std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>> chunk_messages_;  // time, offset
  std::vector<ChunkIndex> chunks_;
  std::map<uint16_t, uint64_t> message_counts_;
  uint16_t schema_count_ = 0;
  uint64_t first_ns_ = 0, last_ns_ = 0, message_count_ = 0;
  uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
};

}  // namespace prism
