// One picture's evidence of each candidate offset of the sun: how well lit and shaded pixels, by
// the mesh and the turned sun, explain its brightness.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/internal/shadow_pixels.h"

namespace pleinair {

// One picture's usable pixels. Vectors have one entry a pixel; shares are pixels x candidates.
struct ShadowPicture {
  std::size_t candidates = 0;  // Suns that `shares` are for.
  std::vector<ShadowPixel> surface;
  std::vector<double> log_radiance;
  std::vector<double> log_blue_over_red;  // NaN where the pixel does not say.
  std::vector<std::uint32_t> plane;
  std::vector<std::uint32_t> tile;
  std::vector<std::uint8_t> shares;  // In quarters, as SunShares gives them.

  std::size_t Size() const { return log_radiance.size(); }
};

// Robust misfit of the entire picture under each candidate: every plane takes the lit and the
// shaded level that suit it, so that neither light nor albedo need be known. Low is good.
std::vector<double> MisfitByCandidate(const ShadowPicture& picture);

// The share of the pixels that are nearer to their own level than to the other. It is computed for
// the pixels that `candidate` puts in the sun and for those that it puts in shade; the smaller one
// is returned. 0 where no plane has levels.
double AgreementOfStates(const ShadowPicture& picture, std::size_t candidate);

// Natural log of blue over red in shade, over that in the sun, on the same planes under
// `candidate`. 0 where no plane has both.
double BluenessOfShade(const ShadowPicture& picture, std::size_t candidate);

// One tile's log-likelihood of each candidate, up to a constant.
struct TileEvidence {
  std::uint32_t tile = 0;
  std::vector<double> log_likelihood;
};

struct PictureEvidence {
  std::vector<TileEvidence> tiles;  // Only tiles that distinguish candidates.
  double contrast = 1.0;            // Lit over shaded radiance, median over shadow pixels.
  bool sunlit = false;              // Some plane has a lit and a shaded part.
};

// With the planes' levels as found under `candidate`. `raised_shares` is as picture.shares, for
// suns at other elevations, all equally likely a priori. A mesh whose eaves or chimneys are a
// little too high or too low moves shadows along the sun's azimuth, and such edges must not support
// another azimuth.
PictureEvidence EvidenceNear(const ShadowPicture& picture,
                             std::size_t candidate,
                             std::span<const std::vector<std::uint8_t>> raised_shares);

}  // namespace pleinair
