// The true light and pictures of a rendered sequence. Only scoring may read this.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "datasets/sequence.h"

namespace pleinair {

// The truth of one frame, in the sequence's radiance units times sr.
struct TruthFrame {
  int frame = 0;                                // 0-based, into the sequence's frames.
  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // Unit, apparent.
  glm::dvec3 sun_irradiance_rgb{0.0};           // Normal to the beam, clouds included.
  glm::dvec3 sky_irradiance_rgb{0.0};           // Horizontal, unoccluded, without the disc.
  // The picture with the object really there: linear, or with_object_ldr/ as the frames_ldr are, by
  // the same camera. And the object's coverage of each pixel (0..255).
  std::optional<std::filesystem::path> with_object;
  std::optional<std::filesystem::path> with_object_ldr;
  std::optional<std::filesystem::path> coverage;

  bool HasPicture() const { return (with_object || with_object_ldr) && coverage; }
};

// Whether the sequence's folder has truth/truth.json.
bool HasTruth(const Sequence& sequence);

// Reads truth/truth.json of the sequence; keys that scoring does not use are ignored. Pictures that
// it does not name are expected under their usual names.
// Throws  std::runtime_error naming file, key and what was expected: no such file, a frame that the
//         sequence does not have or that occurs twice, a path outside the sequence's folder.
std::vector<TruthFrame> ReadTruth(const Sequence& sequence);

// Mean albedos, by name, of the materials for which truth/truth.json has one. Throws
// std::runtime_error as ReadTruth, and where it has none.
std::map<std::string, glm::dvec3> ReadTrueAlbedos(const Sequence& sequence);

}  // namespace pleinair
