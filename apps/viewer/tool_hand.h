// What a press in a picture does with the tool that is taken, whether the pointer presses or the
// cursor that keys move.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "apps/viewer/picture_side.h"

namespace pleinair {

struct ViewModel;

// What the pointer does in the picture.
enum class Tool { kObjects, kMask, kPose, kColour, kResponse, kLens };
inline constexpr int kTools = 6;

struct PressPlace {
  glm::dvec2 pixel{0.0};  // A pixel of the picture on that side.
  PictureSide side = PictureSide::kCamera;
  double reach_px = 0.0;    // How near a mark has to be to be taken.
  bool gives_back = false;  // Whether the mask's brush gives back.
};

// The press of a pointer or a key with each tool but objects, which pointer and keys move directly.
class ToolHand {
 public:
  void Press(const PressPlace& place, ViewModel& model);
  // Once it is down.
  void MoveTo(const glm::dvec2& pixel, ViewModel& model);
  void Release(ViewModel& model);
  // In place of Release: without effect, as if it had not been pressed.
  void LetGo(ViewModel& model);

  bool IsDown() const { return is_down_; }
  // The corner of the mesh that is to be put where the picture shows it.
  const std::optional<glm::dvec3>& HeldCorner() const { return corner_; }

 private:
  void Paint(const glm::dvec2& pixel, ViewModel& model);
  void Lift();

  bool is_down_ = false;
  bool gives_back_ = false;
  glm::dvec2 at_{0.0};
  std::optional<glm::dvec2> painted_;  // The stroke's last place.
  std::optional<glm::dvec3> corner_;
};

// Makes what the tool works on, and shows it the picture. False where it cannot be used here: the
// status says why.
bool TakeUpTool(ViewModel& model);

}  // namespace pleinair
