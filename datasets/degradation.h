// Adds the imperfections of a real recording to a rendered one: to camera, poses, mesh, north and
// survey.
//
// For scoring only: it reads the truth for guessed albedos with a known error, and for the truth's
// pictures as the imperfect camera takes them.
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

// Sizes of the imperfections. All 0: an 8-bit camera with noise, and everything else is known.
struct Imperfections {
  // Imperfections of the camera's pictures, in the order in which they arise.
  // White balance unknown: log deviation of red's and blue's gain over green's.
  double gain_log_stddev = 0.0;
  double exposure_ev = 0.0;       // Above 0: no frame states it, and it varies by about this.
  double veil_share = 0.0;        // Share of the mean picture, added by flare and haze.
  double vignette_share = 0.0;    // Share of the light that the corners lose.
  double saturation = 0.0;        // Gain about the grey axis: 1 + |draw| times this.
  double curve_log_stddev = 0.0;  // Log deviation of a gamma on top of sRGB.
  double sharpening = 0.0;        // Amount of the unsharp mask.
  double jpeg_loss = 0.0;         // The quality is 100 less this.
  // Imperfections of measurements that are made once.
  double pose_deg = 0.0;   // The camera is turned by this about a random axis,
  double pose_m = 0.0;     // and displaced by about this.
  double mesh_m = 0.0;     // Vertices are displaced by about this; those on the ground stay on it.
  double north_deg = 0.0;  // Mesh, objects and cameras are turned by this about the zenith.
  // Imperfections of the survey.
  // Clipped at this times its brightest sky (99th percentile).
  std::optional<double> map_clipped_at;
  bool map_withheld = false;       // Albedos are then the materials', guessed:
  double albedo_log_stddev = 0.0;  // a material's true mean, with about this log error.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The imperfections drawn with a seed. A draw depends only on its imperfection, and scales with its
// size. So sizes can be compared with the same seed, and imperfections can be combined.
class Degradation {
 public:
  // Throws as Imperfections::Validate.
  Degradation(const Imperfections& sizes, std::uint64_t seed);

  // Returns the 8-bit picture that the camera takes of `radiance` as its frame number `frame`;
  // `exposure` is that of a perfect camera. Its noise depends on the seed and on `frame`.
  Rgb8Image Picture(const RgbImage& radiance, double exposure, int frame) const;

  // Writes to the empty `folder` an imperfect recording of `frames` of `source`, numbered from 0.
  // It contains sequence.json, 8-bit frames only, mesh, survey map and all other files of the
  // source's folder except its truth/.
  //
  // Throws  std::runtime_error naming file and what was expected. Refused are a frame without a
  //         linear picture or exposure, a mesh that is no OBJ where vertices are to be moved, and a
  //         truth without mean albedos where they are to be guessed.
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
