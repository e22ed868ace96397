// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// read_mcap.mjs FILE: what @mcap/core and protobufjs find in an exported run, as JSON. Messages are
// decoded by the schemas in the file.
import {readFile} from 'node:fs/promises';
import {McapIndexedReader} from '@mcap/core';
import protobuf from 'protobufjs';
import descriptor from 'protobufjs/ext/descriptor/index.js';

const bytes = await readFile(process.argv[2]);
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  },
});

const types = {}, schemas = {};
for (const channel of reader.channelsById.values()) {
  const schema = reader.schemasById.get(channel.schemaId);
  const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
  types[channel.id] = root.lookupType(schema.name);
  schemas[channel.topic] = schema.name;
}

const result = {counts: {}, schemas};
for await (const message of reader.readMessages()) {
  const topic = reader.channelsById.get(message.channelId).topic;
  result.counts[topic] = (result.counts[topic] ?? 0) + 1;
  const value = types[message.channelId].decode(message.data);
  if (topic === '/tf' && value.parent_frame_id === 'world') {
    result.last_time = String(message.logTime);
    result.last_position = value.translation;
  } else if (topic === '/image') {
    result.png = value.format === 'png' && value.data[1] === 0x50;
  } else if (topic === '/calibration') {
    result.K = value.K;
  } else if (topic === '/points') {
    result.points = value.data.length / value.point_stride;
    result.first_point = [0, 4, 8].map(at => Buffer.from(value.data).readFloatLE(at));
  }
}
console.log(JSON.stringify(result));
