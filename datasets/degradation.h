// A rendered recording made as imperfect as a real one: its camera, poses, mesh, north and survey.
//
// For scoring: it reads the truth where guessed albedos are to be off by a known amount, and shows
// the truth's pictures as the imperfect camera takes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "datasets/sequence.h"
#include "scene/image.h"

namespace pleinair {

// How large each imperfection is. All 0: an 8-bit camera with noise, known in all else.
struct Imperfections {
  // Imperfections of the camera's pictures, in the order in which they arise.
  double gain_log_stddev = 0.0;   // White balance unknown: of red's and blue's gain over green's.
  double exposure_ev = 0.0;       // Above 0 no frame states it, and it wanders by about this.
  double veil_share = 0.0;        // Of the mean picture, added by flare and haze.
  double vignette_share = 0.0;    // Of the light, lost in the corners.
  double saturation = 0.0;        // Gain about the grey axis: 1 + |draw| times this.
  double curve_log_stddev = 0.0;  // Of a gamma on top of sRGB.
  double sharpening = 0.0;        // Amount of the unsharp mask.
  double jpeg_loss = 0.0;         // The quality is 100 less this.
  // Imperfections of measurements that are made once.
  double pose_deg = 0.0;   // The camera is turned by this about some axis,
  double pose_m = 0.0;     // and off by about this.
  double mesh_m = 0.0;     // Vertices are off by about this; those on the ground stay on it.
  double north_deg = 0.0;  // Mesh, objects and cameras are turned by this about the zenith.
  // Imperfections of the survey.
  std::optional<double> map_clipped_at;  // Times its brightest sky (99th percentile).
  bool map_withheld = false;             // Albedos are then the materials', guessed:
  double albedo_log_stddev = 0.0;        // a material's true mean, off by about this.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The imperfections that a seed draws. A draw depends on its imperfection alone, and scales with
// its size: sizes can be compared with the same seed, and imperfections be added.
class Degradation {
 public:
  // Throws as Imperfections::Validate.
  Degradation(const Imperfections& sizes, std::uint64_t seed);

  // The 8-bit picture that the camera takes of `radiance` as its `frame`-th; exposure is what a
  // perfect camera's would be. Its noise depends on the seed and on `frame`.
  Rgb8Image Picture(const RgbImage& radiance, double exposure, int frame) const;

  // Writes to the empty `folder` what a person would have recorded of `frames` of `source`,
  // numbered from 0: sequence.json, 8-bit frames alone, mesh, survey map and what else is in the
  // source's folder, but not its truth/.
  //
  // Throws  std::runtime_error naming file and what was expected: a frame without a linear picture
  //         or exposure, a mesh that is no OBJ where vertices are to be moved, no mean albedos in
  //         the truth where they are to be guessed.
  void Write(const Sequence& source,
             std::span<const int> frames,
             const std::filesystem::path& folder) const;

 private:
  double ExposureFactor(int frame) const;
  void WriteFrames(const Sequence& source,
                   std::span<const int> frames,
                   const std::filesystem::path& folder,
                   Sequence& degraded) const;
  void TurnAndMove(Sequence& degraded) const;
  void WriteMesh(const std::filesystem::path& source, const std::filesystem::path& target) const;
  void WriteGuessedAlbedos(const Sequence& source, const std::filesystem::path& folder) const;

  Imperfections sizes_;
  std::uint64_t seed_;
  glm::dvec3 gain_rgb_{1.0};
  double saturation_ = 1.0;
  double gamma_ = 1.0;
  glm::dmat3 tilt_{1.0};
  glm::dvec3 shift_m_{0.0};
  glm::dmat3 turned_from_true_{1.0};
};

}  // namespace pleinair
