// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export_recorder.h"

#include <algorithm>
#include <map>
#include <set>

#include "prism/base/error.h"
#include "prism/export/export.h"
#include "tools/tool_main.h"

namespace prism {
namespace {

// The piece of the map with most keyframes, the first of those.
int LargestPiece(const Map& map, const std::vector<ExportKeyframe>& keyframes) {
  std::map<int, int> counts;
  for (const ExportKeyframe& keyframe : keyframes) ++counts[map.Piece(map.SegmentOf(keyframe.id))];
  int largest = 0, most = 0;
  for (const auto& [piece, count] : counts) {
    if (count > most) {
      largest = piece;
      most = count;
    }
  }
  return largest;
}

}  // namespace

ExportRecorder::ExportRecorder(const std::string& formats) : formats_(SplitAtCommas(formats)) {
  for (const std::string& name : formats_) {
    if (!IsExportName(name)) {
      throw InputError("--export", "'" + name + "'", "a comma list of " + ExportNames());
    }
  }
}

void ExportRecorder::Add(const FrameResult& frame, const Odometry& odometry) {
  if (formats_.empty() || !frame.is_keyframe) return;
  ExportKeyframe keyframe;
  keyframe.id = frame.keyframe_id;
  keyframe.time_ns = frame.time_ns;
  EncodeFrame(*odometry.window().Get(frame.keyframe_id).frame, &keyframe);
  keyframes_.push_back(std::move(keyframe));
}

std::string ExportRecorder::Write(const std::string& folder,
                                  const Odometry& odometry,
                                  const PlayOrder& play_order) const {
  if (formats_.empty()) return "";
  const Map& map = odometry.map();
  const int piece = LargestPiece(map, keyframes_);
  ExportRun run;
  run.camera = odometry.window().camera;
  run.trajectory = play_order.InFileTimes(map.FrameTrajectory(piece));
  std::set<int> ids;
  for (const ExportKeyframe& keyframe : keyframes_) {
    if (map.Piece(map.SegmentOf(keyframe.id)) != piece) continue;
    run.keyframes.push_back(keyframe);
    run.keyframes.back().world_from_cam = map.CamFromWorld(keyframe.id).Inverse();
    run.keyframes.back().time_ns =
        play_order.InFileTimes({{keyframe.time_ns, SE3()}}).front().time_ns;
    ids.insert(keyframe.id);
  }
  map.ForEachPoint(odometry.window(), [&](const MapPoint& point) {
    if (ids.count(point.keyframe_id) == 0) return;
    run.points.push_back({point.p_in_world, point.rgb, point.keyframe_id, point.px, point.sigma_m});
  });
  return WriteExports(formats_, folder, run);
}

}  // namespace prism
