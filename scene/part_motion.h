// The motion of a part of a mesh file, by the animation of the nodes above it.
#pragma once

#include <optional>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace pleinair {

// Values at times, as in glTF 2.0 (section 3.11, appendix C).
struct KeyTrack {
  enum class Interpolation { kStep, kLinear, kCubicSpline };

  std::vector<double> times_s;  // Ascending; not empty.
  // One a time; of kCubicSpline three: in-tangent, value, out-tangent.
  std::vector<glm::dvec4> values;
  Interpolation interpolation = Interpolation::kLinear;

  // The first value before the first time, the last one after the last.
  glm::dvec4 At(double time_s) const;
  // For unit quaternions (x, y, z, w): LINEAR follows the shorter arc.
  glm::dquat RotationAt(double time_s) const;
};

// A node's transform to its parent's frame. Where no track moves it, `rest` holds.
struct MovingNode {
  glm::dmat4 rest{1.0};
  // For a node that has tracks: the parts of rest.
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
  std::optional<KeyTrack> translation_track;
  std::optional<KeyTrack> rotation_track;
  std::optional<KeyTrack> scale_track;

  bool Moves() const { return translation_track || rotation_track || scale_track; }
  glm::dmat4 ParentFromNodeAt(double time_s) const;
};

// The motion of one part: a chain of nodes whose tracks repeat.
class PartMotion {
 public:
  // Stands still.
  PartMotion() = default;
  // `chain` leads from the file's root to the part; duration_s > 0.
  PartMotion(std::vector<MovingNode> chain, double duration_s);

  bool Moves() const { return !chain_.empty(); }

  // The animation repeats, after its end and before its beginning.
  glm::dmat4 FileFromPart(double time_s) const;
  // Takes the part from where it is at time 0 to where it is at `time_s`; exactly the unit matrix
  // where these are equal. Throws std::runtime_error where the part has no extent at time 0: a
  // scale of 0.
  glm::dmat4 FileFromStart(double time_s) const;

 private:
  std::vector<MovingNode> chain_;
  double duration_s_ = 0.0;
};

}  // namespace pleinair
