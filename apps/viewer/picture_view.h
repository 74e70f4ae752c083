// The pictures in the window: where they are, and what is drawn over them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <glm/vec2.hpp>

#include "apps/viewer/picture_place.h"
#include "apps/viewer/view_model.h"

namespace pleinair {

class PictureView {
 public:
  // Behind all panels; as large as the window's free area allows.
  void Draw(ViewModel& model,
            ViewWindow& window,
            const glm::dvec2& area_origin,
            const glm::dvec2& area_size);
  const PicturePlace& Place() const { return place_; }
  // Place of the other camera's picture, below, while a tool shows one.
  const std::optional<PicturePlace>& OtherPlace() const { return other_place_; }
  // Whether the place is in the camera's picture (or that which a tool shows in its place), or in
  // the other one.
  bool Holds(const glm::dvec2& screen) const { return IsIn(Main(), place_, screen); }
  bool OtherHolds(const glm::dvec2& screen) const {
    return other_place_ && IsIn(other_, *other_place_, screen);
  }

 private:
  // In place of the camera's picture, while a tool shows one of its own.
  bool TakeBoard(const ViewModel& model);
  const Texture& Main() const { return shows_board_ ? board_ : shown_; }
  static bool IsIn(const Texture& texture, const PicturePlace& place, const glm::dvec2& screen);
  void DrawSelection(const ViewModel& model);
  void DrawBalls(const ViewModel& model);
  void DrawWindows(const ViewModel& model);
  void DrawMask(const ViewModel& model, const glm::dvec2& low, const glm::dvec2& high);
  void DrawTool(const ViewModel& model, const glm::dvec2& size);
  void DrawOther(const ViewModel& model, const glm::dvec2& origin, const glm::dvec2& size);
  // Where the cursor is shown, or else the pointer is, in the camera's picture.
  glm::dvec2 HandPixel(const ViewModel& model) const;
  // The picture around the cursor or the pointer, larger.
  void DrawLoupes(const ViewModel& model);
  static void DrawLoupe(const Texture& texture, const PicturePlace& place, const glm::dvec2& pixel);

  PicturePlace place_;
  std::optional<PicturePlace> other_place_;
  Texture shown_;
  Texture other_;
  std::shared_ptr<const Rgb8Image> other_shown_;  // That texture's picture.
  bool shows_board_ = false;
  Texture board_;
  std::shared_ptr<const Rgb8Image> board_shown_;  // That texture's picture.
  Texture overlay_;
  Texture balls_;  // One below the other.
  Texture mask_;
  std::optional<std::int64_t> mask_version_;  // Version of that texture.
  std::int64_t number_ = 0;                   // Number of the frame in the textures.
  bool has_overlay_ = false;
};

}  // namespace pleinair
