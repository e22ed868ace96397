// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"
#include "prism/lightfield/depth_fusion.h"
#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/match_misfit.h"
#include "prism/lightfield/preparation.h"
#include "prism/lightfield/raw_texture.h"
#include "prism/lightfield/smooth_rows.h"

namespace prism {

struct DepthOptions {
  // 1/v searched from; 0: from that of what is 0.2 m away, but from 0.05 at least and 0.1 at most
  // (0.1 for Keplerian cameras and those without metric depth).
  double min_inverse_virtual_depth = 0;
  double max_inverse_virtual_depth = 0.48;  // to; at most 0.5
  double search_step = 0.02;                // in 1/v; half a pixel between neighbouring lenses
  int seed_spacing = 10;        // focused px a side of a cell with one point searched in full
  double min_gradient = 3;      // in raw noise; weaker pixels are not searched
  double max_sigma = 0.02;      // of 1/v; less certain estimates are dropped
  double ambiguity = 35;        // chi square between best and any other match, at least
  double min_information = 3;   // of the gradients over what noise alone pretends
  double max_residual = 2.3;    // RMS over what MatchMisfit expects; occlusions exceed it
  double sigma_floor = 0.0015;  // of 1/v, model errors
  double noise_factor = 1.1;    // on sigma: correlated noise, slant within a patch
  double misfit_factor = 1.1;   // on what MatchMisfit::share_px makes of sigma

  bool IsValid(std::string* error) const;
};

// Inverse virtual depth w = 1/v on the focused grid, semi-dense, with its standard deviation.
//
// A focused pixel X is a virtual point; hypothesis w says where each lens sees it. Around each of
// those positions lies a patch of 7 x 7 raw px. The estimate is the w at which the patches of all
// lenses differ least from their mean (PatchSums), which treats all lenses alike and so has no
// preferred direction. Short and long baselines enter together, weighted by themselves since the
// derivative of a sample by w is its gradient times its baseline.
//
// In an array of several focal lengths the lens types blur a point at w differently, by a spot of
// radius R |w - 1/v_k| with R that of a micro lens. Those much more blurred than the sharpest are
// left out, the others are blurred to the same variance before they are compared: sharp against
// blurred images match best beside the truth.
//
// 1. Seeds: in every cell of seed_spacing focused px, where it has most texture, w is swept over
//    its range (SweepInverseVirtualDepth) and the minimum refined by Gauss-Newton. Flat or double
//    minima are dropped. From what is left over at all of them follows how well lenses can match in
//    this frame (FitMisfit); seeds and all later estimates that match much worse are dropped.
//    So are seeds at places that lenses lose sight of not far above their 1/v: only what noise
//    makes smaller is found there.
// 2. Nodes, every fourth pixel (depth_fusion.h), start from the mean of estimates around them that
//    agree and are refined with lenses and mask held fixed. Beside a contour that is the contour's
//    depth, up to a patch away from it: a node is moved to where the texture lies it is measured
//    on, the mean place of the hessian's terms, and refined there; one that would leave its patch
//    is dropped. Every second node in x and in y is estimated so from the seeds, a draft, and then
//    all of them from the drafts, which are more and nearer: a node that starts far from its 1/v is
//    dropped, or keeps a part of what its start is off by.
// 3. Nodes that a third of their neighbours contradict are dropped; the others become the mean of
//    the neighbours that agree, and the pixels around them are interpolated. Neighbours share raw
//    pixels, so sigma is the mean of theirs, as if their errors were the same.
//
// Large frames are gone through in bands of rows, three times, for the half-pixel images of a frame
// take 16 to 32 bytes a pixel (SmoothRows).
//
// sigma^2 = noise_factor^2 s^2 / hessian + misfit_factor^2 share^2 / sum(d^2) + sigma_floor^2 with
// s^2 the larger of the image noise and the mean squared residual, d the baselines of the lenses
// along the gradient in px per unit of 1/v, and share that of MatchMisfit: what one lens misplaces
// does not average over the pixels of its patch.
class DepthEstimator {
 public:
  // `lenses` must outlive this.
  DepthEstimator(const PlenopticCamera& camera,
                 const LensTable& lenses,
                 const DepthOptions& options);

  // Both outputs on the focused grid, 0 = no measurement. Deterministic, independent of threads.
  void Estimate(const PreparedRaw& raw, ImageF* inverse_virtual_depth, ImageF* sigma);

  const DepthOptions& options() const { return options_; }  // with the range as searched
  // Standard deviation of the noise of PreparedRaw::gray found in the last frame, 0 to 255.
  double noise() const { return texture_.noise(); }
  // How lenses matched in the last frame.
  const MatchMisfit& misfit() const { return misfit_; }

 private:
  struct Estimated {
    float w = 0;  // 0: none
    float sigma = 0;
    float limit = 0;                 // of a seed: SweepMinimum::limit
    float residual = 0;              // mean squared, relative to the noise
    float contrast = 0;              // MatchSample::contrast
    float noise_variance = 0;        // of w, by the noise of the residual
    float baseline_squared = 0;      // sum over the lenses, along the gradient, px^2
    Eigen::Vector2f shift = {0, 0};  // from the position to its texture, focused px
  };

  // Estimates, one a square cell of the focused image.
  struct Cells {
    int side;    // focused px
    int around;  // a node starts from those up to as many cells away in x and in y
    int width, height;
    std::vector<Estimated> estimates;  // row by row

    Cells(int image_width, int image_height, int side, int around);
    Estimated& operator()(int i, int j) { return estimates[static_cast<size_t>(j) * width + i]; }
    const Estimated& operator()(int i, int j) const {
      return estimates[static_cast<size_t>(j) * width + i];
    }
    // Calls visit(estimate) for those up to `cells` away from cell (i, j) in x and in y.
    template <typename Visit>
    void ForEachAround(int i, int j, int cells, const Visit& visit) const;
  };

  // Whether a match is as good as the frame's misfit allows, and certain enough; sets its sigma.
  bool Accept(Estimated* estimated) const;
  void AcceptSeeds();
  void DropTruncatedSeeds();
  // Undistorted raw px of a position on the focused grid.
  Eigen::Vector2f RawPosition(float x, float y) const;
  int TextureAt(const Eigen::Vector2f& raw_px) const;
  Estimated SearchCell(const PreparedRaw& raw, int i, int j) const;
  Estimated Refine(const PreparedRaw& raw,
                   const Eigen::Vector2f& raw_px,
                   float w,
                   int iterations) const;
  // At a pixel, from the estimates around it.
  Estimated RefineFrom(const Cells& starts, const PreparedRaw& raw, int x, int y) const;
  // Refines it where its texture lies; its shift is then from raw_px. Nothing if that is outside of
  // the patch.
  Estimated MoveToTexture(const PreparedRaw& raw,
                          const Eigen::Vector2f& raw_px,
                          Estimated estimated) const;
  // From where the texture of a node lies, a virtual point, to the pixel of the focused image that
  // shows it; focused px.
  Eigen::Vector2f ToPixel(int i, int j, const Estimated& estimated) const;
  float Reach(float w) const;  // DepthNodes
  // Rows of the raw image, begin and end, that virtual points are looked for in whose images are up
  // to `beside_px` raw px beside those of the rows Y0 to Y1, undistorted raw px.
  std::pair<int, int> RowsLookedAt(float Y0, float Y1, float beside_px) const;
  std::pair<int, int> RowsOfCells(int begin, int end) const;
  std::pair<int, int> RowsOfNodes(int begin, int end) const;
  // Calls row(j) for rows 0 to count - 1 of cells or nodes, in parallel where rows_ holds what
  // rows_of(begin, end) says of them.
  template <typename RowsOf, typename Row>
  void ForRows(int count, const RowsOf& rows_of, const Row& row);

  int width_, height_, scale_;
  const LensTable& lenses_;
  DepthOptions options_;
  RawTexture texture_;
  SmoothRows rows_;
  MatchMisfit misfit_;
  Cells seeds_;
  Cells drafts_;
  DepthNodes nodes_;  // before step 3
  DepthNodes fused_;  // after it
};

}  // namespace prism
