#include "datasets/degradation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/camera_noise.h"
#include "datasets/statistics.h"
#include "datasets/truth.h"
#include "scene/image_io.h"
#include "scene/srgb.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

// Each has its own random stream.
enum class Draw {
  kGain,
  kExposure,
  kSaturation,
  kCurve,
  kTilt,
  kShift,
  kMesh,
  kNorth,
  kAlbedo,
  kNoise
};

class Normals {
 public:
  Normals(std::uint64_t seed, Draw draw, int frame = 0) {
    std::seed_seq seeds{static_cast<std::uint32_t>(seed),
                        static_cast<std::uint32_t>(seed >> 32),
                        static_cast<std::uint32_t>(draw),
                        static_cast<std::uint32_t>(frame)};
    engine_.seed(seeds);
  }
  double Next() { return normal_(engine_); }
  glm::dvec3 Next3() {
    const double x = Next();
    const double y = Next();
    return {x, y, Next()};
  }
  // Root mean square length 1.
  glm::dvec3 NextOffset() { return Next3() / std::sqrt(3.0); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

// Exposure wanders as a camera's does: back towards the right one, by a share each frame.
constexpr double kExposureMemory = 0.8;
constexpr double kExposureStep = 0.6;  // Then its deviation settles at exposure_ev.
constexpr double kUnsharpMaskSigmaPx = 1.2;
constexpr double kOnTheGroundM = 0.02;
constexpr double kSamePlaceM = 1e-4;  // Vertices of the mesh's faces that meet there stay together.
// Guesses of one material are off together, and its channels apart: squares add up to 1.
constexpr double kAlbedoTogether = 0.82;
constexpr double kAlbedoApart = 0.58;
constexpr double kDarkestGuess = 0.02;
constexpr double kBrightestGuess = 0.9;
// Quantile of the survey map's upper half that counts as its brightest sky.
constexpr double kBrightestSkyShare = 0.99;

// NaN is black.
double WithinCode(double signal) { return signal > 0.0 ? std::min(signal, 1.0) : 0.0; }

std::string NumberedName(const char* folder, std::size_t frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06zu", frame);
  return std::string(folder) + "/" + name + extension;
}

void RequireNotNegative(const char* name, double value) {
  if (value >= 0.0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) +
                              ": expected 0 or more");
}

// The source may be read-only: what is copied is not.
void CopyFile(const fs::path& from, const fs::path& to) {
  fs::create_directories(to.parent_path());
  fs::copy_file(from, to, fs::copy_options::overwrite_existing);
  fs::permissions(to, fs::perms::owner_write, fs::perm_options::add);
}

std::vector<std::string> LinesOf(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    lines.push_back(std::move(line));
  }
  return lines;
}

void WriteLines(const fs::path& file, const std::vector<std::string>& lines) {
  std::ofstream stream(file, std::ios::trunc);
  for (const std::string& line : lines) stream << line << '\n';
  stream.close();
  if (!stream) throw std::runtime_error(file.string() + ": cannot be written");
}

// The word of a line "KEY WORD"; none for other lines.
std::optional<std::string> WordAfter(const std::string& line, const char* key) {
  std::istringstream words(line);
  std::string first;
  std::string second;
  if (!(words >> first >> second) || first != key) return std::nullopt;
  return second;
}

glm::dvec3 VectorOf(const std::string& line) {
  std::istringstream words(line);
  std::string key;
  glm::dvec3 v(0.0);
  words >> key >> v.x >> v.y >> v.z;
  return v;
}

template <typename... Numbers>
std::string Line(const char* format, Numbers... numbers) {
  char text[128];
  std::snprintf(text, sizeof(text), format, numbers...);
  return text;
}

glm::dmat4 Rotation(const glm::dmat3& rotation) { return glm::dmat4(rotation); }

glm::dmat3 Turn(double degrees, const glm::dvec3& axis) {
  return glm::dmat3(glm::rotate(glm::dmat4(1.0), RadFromDeg(degrees), glm::normalize(axis)));
}

RgbImage ClippedMap(RgbImage map, double times_brightest_sky) {
  std::vector<double> sky;
  for (int y = 0; y < map.height / 2; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::vec3& rgb = map.At(x, y);
      sky.push_back(std::max({rgb.x, rgb.y, rgb.z}));
    }
  }
  const auto limit =
      static_cast<float>(times_brightest_sky * Percentile(std::move(sky), kBrightestSkyShare));
  for (glm::vec3& rgb : map.pixels) rgb = glm::min(rgb, glm::vec3(limit));
  return map;
}

// Names in the source's folder that are written differently, or left out.
bool IsReplaced(const Sequence& source, const fs::path& relative) {
  const fs::path top = *relative.begin();
  if (top == "truth" || relative == "sequence.json" || relative == source.scene_mesh) return true;
  if (source.environment && relative == source.environment->image) return true;
  return std::any_of(source.frames.begin(), source.frames.end(), [&](const FrameEntry& frame) {
    return relative == frame.image || relative == frame.image_ldr;
  });
}

}  // namespace

void Imperfections::Validate() const {
  const std::pair<const char*, double> numbers[] = {
      {"gain_log_stddev", gain_log_stddev},
      {"exposure_ev", exposure_ev},
      {"veil_share", veil_share},
      {"vignette_share", vignette_share},
      {"saturation", saturation},
      {"curve_log_stddev", curve_log_stddev},
      {"sharpening", sharpening},
      {"jpeg_loss", jpeg_loss},
      {"pose_deg", pose_deg},
      {"pose_m", pose_m},
      {"mesh_m", mesh_m},
      {"north_deg", north_deg},
      {"map_clipped_at", map_clipped_at.value_or(1.0)},
      {"albedo_log_stddev", albedo_log_stddev}};
  for (const auto& [name, value] : numbers) RequireNotNegative(name, value);
  if (!(vignette_share < 1.0)) {
    throw std::invalid_argument("vignette_share is " + std::to_string(vignette_share) +
                                ": expected less than 1");
  }
  if (!(jpeg_loss <= 100.0)) {
    throw std::invalid_argument("jpeg_loss is " + std::to_string(jpeg_loss) +
                                ": expected 0 to 100");
  }
}

Degradation::Degradation(const Imperfections& sizes, std::uint64_t seed)
    : sizes_(sizes), seed_(seed) {
  sizes_.Validate();
  gain_rgb_ = glm::exp(sizes_.gain_log_stddev * Normals(seed, Draw::kGain).Next3());
  gain_rgb_ /= gain_rgb_.y;
  saturation_ = 1.0 + sizes_.saturation * std::abs(Normals(seed, Draw::kSaturation).Next());
  gamma_ = std::exp(sizes_.curve_log_stddev * Normals(seed, Draw::kCurve).Next());
  tilt_ = Turn(sizes_.pose_deg, Normals(seed, Draw::kTilt).Next3());
  shift_m_ = sizes_.pose_m * Normals(seed, Draw::kShift).NextOffset();
  const double side = Normals(seed, Draw::kNorth).Next() < 0.0 ? -1.0 : 1.0;
  turned_from_true_ = Turn(side * sizes_.north_deg, {0.0, 0.0, 1.0});
}

double Degradation::ExposureFactor(int frame) const {
  Normals draws(seed_, Draw::kExposure);
  double ev = 0.0;
  for (int i = 0; i <= frame; ++i) {
    ev = kExposureMemory * ev + kExposureStep * sizes_.exposure_ev * draws.Next();
  }
  return std::exp2(ev);
}

Rgb8Image Degradation::Picture(const RgbImage& radiance, double exposure, int frame) const {
  const double factor = exposure * ExposureFactor(frame);
  glm::dvec3 mean(0.0);
  for (const glm::vec3& rgb : radiance.pixels) mean += glm::dvec3(rgb);
  mean *= factor / static_cast<double>(std::max<std::size_t>(1, radiance.pixels.size()));
  const glm::dvec3 veil = sizes_.veil_share * gain_rgb_ * mean;

  const CameraNoise noise;
  Normals draws(seed_, Draw::kNoise, frame);
  const double centre_x = 0.5 * (radiance.width - 1);
  const double centre_y = 0.5 * (radiance.height - 1);
  const double corner2 =
      0.25 * (double(radiance.width) * radiance.width + double(radiance.height) * radiance.height);
  RgbImage encoded(radiance.width, radiance.height);
  for (int y = 0; y < radiance.height; ++y) {
    for (int x = 0; x < radiance.width; ++x) {
      const double dx = x - centre_x;
      const double dy = y - centre_y;
      const double kept = 1.0 - sizes_.vignette_share * (dx * dx + dy * dy) / corner2;
      glm::dvec3 signal = kept * (factor * gain_rgb_ * glm::dvec3(radiance.At(x, y)) + veil);
      const double grey = (signal.x + signal.y + signal.z) / 3.0;
      signal = grey + saturation_ * (signal - grey);
      for (int c = 0; c < 3; ++c) {
        const double exact = WithinCode(signal[c]);
        const double noisy = WithinCode(exact + draws.Next() * std::sqrt(noise.Variance(exact)));
        encoded.At(x, y)[c] = static_cast<float>(std::pow(SrgbFromLinear(noisy), gamma_));
      }
    }
  }
  if (sizes_.sharpening > 0.0) {
    cv::Mat sharp(encoded.height, encoded.width, CV_32FC3, encoded.pixels.data());
    cv::Mat smooth;
    cv::GaussianBlur(sharp, smooth, cv::Size(0, 0), kUnsharpMaskSigmaPx);
    cv::addWeighted(sharp, 1.0 + sizes_.sharpening, smooth, -sizes_.sharpening, 0.0, sharp);
  }
  Rgb8Image codes(encoded.width, encoded.height);
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    codes.pixels[i] = glm::u8vec3(glm::clamp(255.0f * encoded.pixels[i] + 0.5f, 0.0f, 255.0f));
  }
  return codes;
}

void Degradation::Write(const Sequence& source,
                        std::span<const int> frames,
                        const fs::path& folder) const {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(source.folder)) {
    const fs::path relative = entry.path().lexically_relative(source.folder);
    if (!entry.is_regular_file() || IsReplaced(source, relative)) continue;
    CopyFile(entry.path(), folder / relative);
  }
  Sequence degraded = source;
  degraded.folder = folder;
  WriteFrames(source, frames, folder, degraded);
  TurnAndMove(degraded);
  WriteMesh(source.folder / source.scene_mesh, folder / source.scene_mesh);
  if (degraded.environment && sizes_.map_withheld) {
    degraded.sun_direction_enu = degraded.environment->sun_direction_enu;
    degraded.environment.reset();
    degraded.diffuse_mask.reset();  // It is one over the map.
    degraded.albedos_assumed = true;
    WriteGuessedAlbedos(source, folder);
  } else if (degraded.environment) {
    const fs::path& map = degraded.environment->image;
    if (sizes_.map_clipped_at) {
      WriteExr(folder / map,
               ClippedMap(ReadRadianceImage(source.folder / map), *sizes_.map_clipped_at),
               ExrPrecision::kFloat);
    } else {
      CopyFile(source.folder / map, folder / map);
    }
  }
  WriteSequence(degraded, folder);
}

void Degradation::WriteFrames(const Sequence& source,
                              std::span<const int> frames,
                              const fs::path& folder,
                              Sequence& degraded) const {
  fs::create_directories(folder / "frames_ldr");
  degraded.response_ldr = "srgb8";
  degraded.frames.clear();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameEntry entry = source.frames.at(static_cast<std::size_t>(frames[i]));
    const std::optional<double> exposure = entry.EffectiveExposure();
    if (!entry.image || !exposure) {
      throw std::runtime_error((source.folder / "sequence.json").string() + ": frames[" +
                               std::to_string(frames[i]) +
                               "]: expected an image and its exposure, to take a picture of");
    }
    const int frame = static_cast<int>(i);
    entry.image_ldr = NumberedName("frames_ldr", i, ".jpg");
    WriteJpeg(folder / *entry.image_ldr,
              Picture(ReadRadianceImage(source.folder / *entry.image), *exposure, frame),
              static_cast<int>(100.0 - sizes_.jpeg_loss));
    entry.image.reset();
    entry.exposure_s.reset();
    entry.exposure.reset();
    if (!(sizes_.exposure_ev > 0.0)) entry.exposure = exposure;
    degraded.frames.push_back(std::move(entry));
  }
}

void Degradation::TurnAndMove(Sequence& degraded) const {
  const glm::dmat4 turned_from_true = Rotation(turned_from_true_);
  const glm::dmat4 off_from_camera = glm::translate(glm::dmat4(1.0), shift_m_) * Rotation(tilt_);
  const auto turn_camera = [&](std::optional<glm::dmat4>& camera_from_world) {
    if (!camera_from_world) return;
    camera_from_world = off_from_camera * *camera_from_world * glm::transpose(turned_from_true);
  };
  turn_camera(degraded.camera_from_world);
  for (FrameEntry& frame : degraded.frames) turn_camera(frame.camera_from_world);
  for (VirtualObjectEntry& object : degraded.virtual_objects) {
    object.world_from_object = turned_from_true * object.world_from_object;
  }
  for (WindowEntry& window : degraded.windows) {
    for (glm::dvec3& corner : window.polygon_world_m) corner = turned_from_true_ * corner;
  }
  if (degraded.environment) {
    degraded.environment->position_m = turned_from_true_ * degraded.environment->position_m;
  }
}

void Degradation::WriteMesh(const fs::path& source, const fs::path& target) const {
  if (!(sizes_.mesh_m > 0.0) && !(sizes_.north_deg > 0.0)) {
    CopyFile(source, target);
    return;
  }
  if (source.extension() != ".obj") {
    throw std::runtime_error(source.string() + ": expected an OBJ file, to move its vertices");
  }
  Normals draws(seed_, Draw::kMesh);
  std::map<std::array<long long, 3>, glm::dvec3> offsets;
  std::vector<std::string> lines = LinesOf(source);
  for (std::string& line : lines) {
    if (line.starts_with("v ")) {
      const glm::dvec3 v = VectorOf(line);
      const auto cell = [](double metres) { return std::llround(metres / kSamePlaceM); };
      const auto [found, is_new] = offsets.try_emplace({cell(v.x), cell(v.y), cell(v.z)});
      if (is_new) {
        found->second = sizes_.mesh_m * draws.NextOffset();
        if (std::abs(v.z) < kOnTheGroundM) found->second.z = 0.0;
      }
      const glm::dvec3 moved = turned_from_true_ * (v + found->second);
      line = Line("v %.5f %.5f %.5f", moved.x, moved.y, moved.z);
    } else if (line.starts_with("vn ")) {
      const glm::dvec3 turned = turned_from_true_ * VectorOf(line);
      line = Line("vn %.5f %.5f %.5f", turned.x, turned.y, turned.z);
    }
  }
  WriteLines(target, lines);
}

void Degradation::WriteGuessedAlbedos(const Sequence& source, const fs::path& folder) const {
  const std::map<std::string, glm::dvec3> albedos = ReadTrueAlbedos(source);
  Normals draws(seed_, Draw::kAlbedo);
  const fs::path mesh = folder / source.scene_mesh;
  for (const std::string& mesh_line : LinesOf(mesh)) {
    const std::optional<std::string> library = WordAfter(mesh_line, "mtllib");
    if (!library) continue;
    const fs::path file = mesh.parent_path() / *library;
    std::vector<std::string> lines = LinesOf(file);
    auto albedo = albedos.end();
    for (std::string& line : lines) {
      if (const auto name = WordAfter(line, "newmtl")) albedo = albedos.find(*name);
      if (!WordAfter(line, "Kd") || albedo == albedos.end()) continue;
      const double together = kAlbedoTogether * draws.Next();
      const glm::dvec3 factor =
          glm::exp(sizes_.albedo_log_stddev * (together + kAlbedoApart * draws.Next3()));
      const glm::dvec3 guess = glm::clamp(
          factor * albedo->second, glm::dvec3(kDarkestGuess), glm::dvec3(kBrightestGuess));
      line = Line("Kd %.4f %.4f %.4f", guess.x, guess.y, guess.z);
    }
    WriteLines(file, lines);
  }
}

}  // namespace pleinair
