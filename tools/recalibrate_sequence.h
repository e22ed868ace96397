// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/calibration/recalibration.h"
#include "prism/run/sequence.h"

namespace prism {

// Recalibrate on a sequence of files, and what came of each pass on the command line. Throws
// InputError naming the sequence if it does not tell b_L0.
RecalibrationResult RecalibrateSequence(const SequenceOptions& sequence,
                                        const RecalibrationOptions& options);

}  // namespace prism
