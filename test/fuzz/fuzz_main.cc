// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// The entry of libFuzzer. The environment's PRISM_FUZZ_TARGET names the target (FuzzTargets).
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include <glog/logging.h>

#include "test/fuzz/targets.h"

namespace {

prism::FuzzTarget target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** argv) {
  google::InitGoogleLogging((*argv)[0]);
  FLAGS_minloglevel = google::GLOG_ERROR;
  const char* const name = std::getenv("PRISM_FUZZ_TARGET");
  CHECK(name != nullptr && prism::FuzzTargets().count(name) == 1) << "PRISM_FUZZ_TARGET";
  target = prism::FuzzTargets().at(name);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  target(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
