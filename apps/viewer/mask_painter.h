// Where the estimate may take samples, painted over the picture.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "apps/viewer/frame_worker.h"
#include "scene/image.h"

namespace pleinair {

// Of a camera that stands still: the mask is over its picture.
class MaskPainter {
 public:
  explicit MaskPainter(std::shared_ptr<const ViewedSite> site);

  // The same site, read again.
  void SetSite(std::shared_ptr<const ViewedSite> site) { site_ = std::move(site); }

  // Empty where a mask can be painted; else why not, in a line.
  const std::string& WhyNot() const { return why_not_; }
  const Gray8Image& Mask() const { return mask_; }  // 255: may be sampled.
  // Changes with every stroke.
  std::int64_t Version() const { return version_; }
  bool HasUnsavedStrokes() const { return version_ != saved_version_; }
  double MaskedShare() const;

  // A stroke is one to undo. Discs from one place to the other; `may_be_sampled` false leaves them
  // out.
  void BeginStroke();
  void Paint(const glm::dvec2& from, const glm::dvec2& to, double radius_px, bool may_be_sampled);
  // All of the surface (the mesh's group) that the pixel shows.
  void PaintSurface(const glm::dvec2& pixel, bool may_be_sampled);
  void Undo();

  // As the site's diffuse_mask. Throws std::runtime_error, one line.
  void Save();

 private:
  void PaintDisc(const glm::dvec2& pixel, double radius_px, std::uint8_t value);

  std::shared_ptr<const ViewedSite> site_;
  std::string why_not_;
  Gray8Image mask_;
  std::vector<Gray8Image> undone_to_;
  std::int64_t version_ = 0;
  std::int64_t saved_version_ = 0;
};

}  // namespace pleinair
