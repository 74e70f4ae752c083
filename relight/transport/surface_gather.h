// What the pixels of one view show of the patch scene, and how they gather light: at a few of them
// by rays, at the rest by blending. Shared by the survey's map and the camera's view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/pixel_blocks.h"
#include "relight/transport/sun_disc.h"
#include "relight/transport/transport.h"
#include "relight/transport/view_rays.h"
#include "scene/surface_view.h"

namespace pleinair {

class SurfaceGather {
 public:
  SurfaceGather() = default;
  // One receiver for each plane that a block of `block_px` pixels shows, at the pixel nearest to
  // the middle of what shows it. A pixel blends the same plane's receivers of the four blocks
  // around it, bilinearly. block_px 1 gathers at every pixel. Throws std::invalid_argument for
  // block_px < 1.
  SurfaceGather(const PatchScene& scene,
                const ViewRays& rays,
                const SurfaceView& view,
                int block_px,
                const GatherOptions& options);

  const GatheredRays& Rays() const { return *rays_; }
  std::size_t PixelCount() const { return entry_begin_.empty() ? 0 : entry_begin_.size() - 1; }
  // Spreads values of the receivers over the pixels; zero where no surface is. Shape: PixelCount().
  void Blend(std::span<const glm::vec3> at_receivers, std::vector<glm::vec3>& at_pixels) const;

  // Defined in relight/internal/serialization.h.
  template <class Archive>
  void serialize(Archive& archive);

 private:
  struct Entry {
    std::uint32_t receiver;
    float weight;
  };
  std::shared_ptr<const GatheredRays> rays_ = std::make_shared<const GatheredRays>();
  std::vector<std::uint32_t> entry_begin_;  // Per pixel, entries [begin, next begin).
  std::vector<Entry> entries_;
};

// Share of the disc seen at each pixel; 0 where no surface is.
GrayImage SunVisibility(const RayCaster& caster, const SunDisc& disc, const SurfaceView& view);

// The same, but planar blocks whose four corners all see the disc, or all do not, are treated as
// uniform. Keeps the memory of `visibility`.
void SunVisibilityInBlocks(const RayCaster& caster,
                           const SunDisc& disc,
                           const PlanarBlocks& planar,
                           const SurfaceView& view,
                           GrayImage& visibility);

}  // namespace pleinair
