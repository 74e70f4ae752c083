#include "apps/viewer/mask_painter.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "datasets/diffuse_mask.h"
#include "objects/surface_point.h"

namespace pleinair {
namespace {

constexpr std::uint8_t kMaySample = 255;

}  // namespace

MaskPainter::MaskPainter(std::shared_ptr<const ViewedSite> site) : site_(std::move(site)) {
  const Sequence& sequence = site_->loaded->sequence;
  now_.mask = Gray8Image(sequence.intrinsics.width_px, sequence.intrinsics.height_px, kMaySample);
  if (!sequence.camera_from_world || site_->camera_moves) {
    why_not_ = "a mask is painted over the picture of a camera that stands still";
    return;
  }
  try {
    const auto known = ReadDiffuseMask(sequence);
    if (!known) return;
    if (known->is_over_map) {
      why_not_ = "the site has a mask over its survey map";
    } else {
      now_.mask = known->image;
    }
  } catch (const std::exception& error) {
    why_not_ = error.what();
  }
}

double MaskPainter::MaskedShare() const {
  const auto masked = std::count_if(
      Mask().pixels.begin(), Mask().pixels.end(), [](auto value) { return value != kMaySample; });
  return static_cast<double>(masked) /
         static_cast<double>(std::max<std::size_t>(1, Mask().pixels.size()));
}

void MaskPainter::BeginStroke() {
  undo_.Remember(now_);
  is_in_stroke_ = true;
}

void MaskPainter::DropStroke() {
  if (std::exchange(is_in_stroke_, false)) undo_.Drop(now_);
}

void MaskPainter::Paint(const glm::dvec2& from,
                        const glm::dvec2& to,
                        double radius_px,
                        bool may_be_sampled) {
  const int steps = static_cast<int>(std::ceil(glm::distance(from, to) / (0.3 * radius_px)));
  for (int i = 0; i <= steps; ++i) {
    const double share = steps > 0 ? static_cast<double>(i) / steps : 1.0;
    PaintDisc(glm::mix(from, to, share), radius_px, may_be_sampled ? kMaySample : 0);
  }
  now_.version = ++last_version_;
}

void MaskPainter::PaintDisc(const glm::dvec2& pixel, double radius_px, std::uint8_t value) {
  const int top = std::max(0, static_cast<int>(std::ceil(pixel.y - radius_px)));
  const int bottom =
      std::min(now_.mask.height - 1, static_cast<int>(std::floor(pixel.y + radius_px)));
  for (int y = top; y <= bottom; ++y) {
    const double half =
        std::sqrt(std::max(0.0, radius_px * radius_px - (y - pixel.y) * (y - pixel.y)));
    const int left = std::max(0, static_cast<int>(std::ceil(pixel.x - half)));
    const int right = std::min(now_.mask.width - 1, static_cast<int>(std::floor(pixel.x + half)));
    for (int x = left; x <= right; ++x) now_.mask.At(x, y) = value;
  }
}

void MaskPainter::PaintSurface(const glm::dvec2& pixel, bool may_be_sampled) {
  const Camera camera = site_->loaded->sequence.CameraOfFrame(0);
  const Mesh& mesh = site_->loaded->site.model.mesh;
  const auto picked = SurfaceAt(site_->caster, mesh, camera, pixel);
  if (!picked || mesh.triangle_group.empty()) return;
  const std::uint32_t group = mesh.triangle_group[picked->triangle];
  tbb::parallel_for(0, now_.mask.height, [&](int y) {
    for (int x = 0; x < now_.mask.width; ++x) {
      const auto seen = SurfaceAt(site_->caster, mesh, camera, {x, y});
      if (seen && mesh.triangle_group[seen->triangle] == group) {
        now_.mask.At(x, y) = may_be_sampled ? kMaySample : 0;
      }
    }
  });
  now_.version = ++last_version_;
}

void MaskPainter::Undo() {
  is_in_stroke_ = false;
  undo_.Undo(now_);
}

void MaskPainter::Redo() {
  is_in_stroke_ = false;
  undo_.Redo(now_);
}

void MaskPainter::Save() {
  ReplaceDiffuseMask(site_->loaded->sequence, now_.mask);
  saved_version_ = now_.version;
}

}  // namespace pleinair
