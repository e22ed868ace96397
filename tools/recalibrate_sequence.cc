// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/recalibrate_sequence.h"

#include <cstdio>
#include <memory>

#include "prism/base/error.h"

namespace prism {

RecalibrationResult RecalibrateSequence(const SequenceOptions& sequence_options,
                                        const RecalibrationOptions& options) {
  const PlenopticCamera camera = Sequence(sequence_options).camera();
  RecalibrationResult result = Recalibrate(camera, options, [&] {
    return [sequence = std::make_shared<Sequence>(sequence_options)] { return sequence->Next(); };
  });
  for (size_t i = 0; i < result.passes.size(); ++i) {
    const RecalibrationPass& pass = result.passes[i];
    std::printf("pass %zu: ", i + 1);
    if (pass.sigma_m > 0) {
      std::printf("b_L0 moves by %+.2f um +- %.2f, ", 1e6 * pass.moved_m, 1e6 * pass.sigma_m);
    }
    std::printf("%.0f %% of the frames tracked%s\n",
                100 * pass.tracked,
                pass.segments > 1 ? ", in several segments" : "");
  }
  if (!result.problem.empty()) {
    throw InputError(sequence_options.sequence, result.problem, "a sequence that tells b_L0");
  }
  std::printf("b_L0 %.4f mm +- %.4f, was %.4f\n",
              1e3 * result.camera.main_lens_mla_distance,
              1e3 * result.sigma_m,
              1e3 * camera.main_lens_mla_distance);
  std::fflush(stdout);
  return result;
}

}  // namespace prism
