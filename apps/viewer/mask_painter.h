// Where the estimate may take samples, painted over the picture.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>

#include "apps/viewer/frame_worker.h"
#include "apps/viewer/undo_stack.h"
#include "scene/image.h"

namespace pleinair {

// Paints the mask of a camera that stands still: the mask is over its picture.
class MaskPainter {
 public:
  explicit MaskPainter(std::shared_ptr<const ViewedSite> site);

  // The same site, read again.
  void SetSite(std::shared_ptr<const ViewedSite> site) { site_ = std::move(site); }

  // Empty where a mask can be painted; else why not, in a line.
  const std::string& WhyNot() const { return why_not_; }
  const Gray8Image& Mask() const { return now_.mask; }  // 255: may be sampled.
  // Another one for each mask; that of one that is brought back comes back with it.
  std::int64_t Version() const { return now_.version; }
  bool HasUnsavedStrokes() const { return now_.version != saved_version_; }
  double MaskedShare() const;

  // A stroke is one to undo, from BeginStroke to EndStroke; or to DropStroke, after which all is as
  // before. Discs from one place to the other; `may_be_sampled` false leaves them
  // out.
  void BeginStroke();
  void EndStroke() { is_in_stroke_ = false; }
  void DropStroke();
  void Paint(const glm::dvec2& from, const glm::dvec2& to, double radius_px, bool may_be_sampled);
  // All of the surface (the mesh's group) that the pixel shows.
  void PaintSurface(const glm::dvec2& pixel, bool may_be_sampled);
  void Undo();
  void Redo();

  // As the site's diffuse_mask. Throws std::runtime_error, one line.
  void Save();

 private:
  struct Painted {
    Gray8Image mask;
    std::int64_t version = 0;
  };

  void PaintDisc(const glm::dvec2& pixel, double radius_px, std::uint8_t value);

  std::shared_ptr<const ViewedSite> site_;
  std::string why_not_;
  Painted now_;
  UndoStack<Painted> undo_;
  bool is_in_stroke_ = false;
  std::int64_t last_version_ = 0;
  std::int64_t saved_version_ = 0;
};

}  // namespace pleinair
