// COLMAP's cameras, images and points3D, binary and text.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>

#include <glm/gtc/quaternion.hpp>

#include "datasets/reconstruction/internal/reconstruction_builder.h"
#include "datasets/reconstruction/reconstruction_file.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "COLMAP's binary files are read as such");

constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};

struct CameraModel {
  std::string_view name;
  std::size_t parameters;
};

// In the order of COLMAP's numbers for them.
constexpr std::array kCameraModels = {CameraModel{"SIMPLE_PINHOLE", 3},
                                      CameraModel{"PINHOLE", 4},
                                      CameraModel{"SIMPLE_RADIAL", 4},
                                      CameraModel{"RADIAL", 5},
                                      CameraModel{"OPENCV", 8},
                                      CameraModel{"OPENCV_FISHEYE", 8},
                                      CameraModel{"FULL_OPENCV", 12},
                                      CameraModel{"FOV", 5},
                                      CameraModel{"SIMPLE_RADIAL_FISHEYE", 4},
                                      CameraModel{"RADIAL_FISHEYE", 5},
                                      CameraModel{"THIN_PRISM_FISHEYE", 12}};
constexpr std::size_t kMostParameters = 12;

[[noreturn]] void RefuseModel(const std::string& where, std::string_view name) {
  throw std::runtime_error(
      where + ": " + std::string(name) +
      ": expected a camera of the model SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV "
      "(`colmap image_undistorter` makes pictures of a PINHOLE camera)");
}

CameraIntrinsics IntrinsicsOf(const std::string& where,
                              std::string_view model,
                              int width_px,
                              int height_px,
                              std::span<const double> p) {
  CameraIntrinsics camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  const bool one_focal_length =
      model == "SIMPLE_PINHOLE" || model == "SIMPLE_RADIAL" || model == "RADIAL";
  camera.fx_px = p[0];
  camera.fy_px = one_focal_length ? p[0] : p[1];
  const auto rest = p.subspan(one_focal_length ? 1 : 2);
  camera.cx_px = rest[0] - 0.5;
  camera.cy_px = rest[1] - 0.5;
  const auto k = rest.subspan(2);
  if (model == "SIMPLE_RADIAL") {
    camera.distortion = {k[0]};
  } else if (model == "RADIAL") {
    camera.distortion = {k[0], k[1]};
  } else if (model == "OPENCV") {
    camera.distortion = {k[0], k[1], k[2], k[3]};
  } else if (model == "FULL_OPENCV" && k[5] == 0.0 && k[6] == 0.0 && k[7] == 0.0) {
    camera.distortion = {k[0], k[1], k[2], k[3], k[4]};
  } else if (model != "SIMPLE_PINHOLE" && model != "PINHOLE") {
    RefuseModel(where, model);
  }
  return camera;
}

glm::dmat4 PoseOf(const std::array<double, 4>& wxyz, const glm::dvec3& translation) {
  const glm::dquat q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  glm::dmat4 pose = glm::dmat4(glm::mat3_cast(glm::normalize(q)));
  // A quaternion of no length, or beyond all bounds, gives no rotation: the builder refuses it.
  if (!(glm::length(q) > 1e-100)) pose = glm::dmat4(0.0);
  pose[3] = glm::dvec4(translation, 1.0);
  return pose;
}

// Numbers of a binary file, one after the other.
class BinaryCursor {
 public:
  explicit BinaryCursor(const fs::path& file) : file_(file.string()), bytes_(ReadWholeFile(file)) {}

  template <typename Number>
  Number Take() {
    Number value{};
    Require(sizeof(Number));
    std::memcpy(&value, bytes_.data() + at_, sizeof(Number));
    at_ += sizeof(Number);
    return value;
  }
  template <std::size_t N>
  std::array<double, N> TakeDoubles() {
    std::array<double, N> values{};
    for (double& value : values) value = Take<double>();
    return values;
  }
  std::string TakeText() {
    std::string text;
    while (const char c = Take<char>()) text += c;
    return text;
  }
  // Number of records of `least_bytes` each: never more than the file can hold.
  std::uint64_t TakeCount(std::size_t least_bytes) {
    const auto count = Take<std::uint64_t>();
    if (count > (bytes_.size() - at_) / least_bytes) {
      throw std::runtime_error(file_ + ": byte " + std::to_string(at_ - sizeof(count)) +
                               ": expected no more entries than the file has room for, found " +
                               std::to_string(count));
    }
    return count;
  }
  void Skip(std::uint64_t bytes) {
    Require(bytes);
    at_ += static_cast<std::size_t>(bytes);
  }
  void RequireEnd() const {
    if (at_ != bytes_.size()) {
      throw std::runtime_error(Where() + ": expected the end of the file");
    }
  }
  std::string Where() const { return file_ + ": byte " + std::to_string(at_); }

 private:
  void Require(std::uint64_t bytes) const {
    if (bytes > bytes_.size() - at_) {
      throw std::runtime_error(Where() + ": the file ends before it is complete");
    }
  }

  std::string file_;
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
};

void ReadCamerasBinary(const fs::path& file, ReconstructionBuilder& builder) {
  BinaryCursor at(file);
  const std::uint64_t count = at.TakeCount(2 * sizeof(std::int32_t) + 2 * sizeof(std::uint64_t));
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string where = at.Where();
    const auto id = at.Take<std::uint32_t>();
    const auto model = at.Take<std::int32_t>();
    const auto width = at.Take<std::uint64_t>();
    const auto height = at.Take<std::uint64_t>();
    if (model < 0 || model >= static_cast<std::int32_t>(kCameraModels.size())) {
      RefuseModel(where, "model " + std::to_string(model));
    }
    const CameraModel& known = kCameraModels[static_cast<std::size_t>(model)];
    std::array<double, kMostParameters> parameters{};
    for (std::size_t p = 0; p < known.parameters; ++p) parameters[p] = at.Take<double>();
    constexpr std::uint64_t kLargest = 1U << 20U;  // The builder has the true bound.
    builder.AddCamera(where,
                      std::to_string(id),
                      IntrinsicsOf(where,
                                   known.name,
                                   static_cast<int>(std::min(width, kLargest)),
                                   static_cast<int>(std::min(height, kLargest)),
                                   parameters));
  }
  at.RequireEnd();
}

void ReadImagesBinary(const fs::path& file, ReconstructionBuilder& builder) {
  BinaryCursor at(file);
  const std::uint64_t count = at.TakeCount(7 * sizeof(double) + 2 * sizeof(std::uint32_t) + 9);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string where = at.Where();
    at.Take<std::uint32_t>();  // Its id: pictures have names.
    const auto rotation = at.TakeDoubles<4>();
    const auto translation = at.TakeDoubles<3>();
    const auto camera = at.Take<std::uint32_t>();
    const std::string name = at.TakeText();
    std::vector<ReconstructionBuilder::Observed> observed;
    const std::uint64_t pixels = at.TakeCount(2 * sizeof(double) + sizeof(std::uint64_t));
    for (std::uint64_t p = 0; p < pixels; ++p) {
      const auto pixel = at.TakeDoubles<2>();
      const auto point = at.Take<std::uint64_t>();
      if (point == kNoPoint) continue;
      observed.push_back({static_cast<std::int64_t>(point), {pixel[0] - 0.5, pixel[1] - 0.5}});
    }
    builder.AddPicture(where,
                       name,
                       std::to_string(camera),
                       PoseOf(rotation, {translation[0], translation[1], translation[2]}),
                       std::move(observed));
  }
  at.RequireEnd();
}

void ReadPointsBinary(const fs::path& file, ReconstructionBuilder& builder) {
  BinaryCursor at(file);
  const std::uint64_t count = at.TakeCount(6 * sizeof(std::uint64_t) + 3);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string where = at.Where();
    const auto id = at.Take<std::uint64_t>();
    const auto position = at.TakeDoubles<3>();
    glm::dvec3 colour;
    for (int c = 0; c < 3; ++c) colour[c] = at.Take<std::uint8_t>();
    at.Take<double>();  // Its reprojection error.
    constexpr std::uint64_t kTrackBytes = 2 * sizeof(std::uint32_t);
    at.Skip(at.TakeCount(kTrackBytes) * kTrackBytes);
    builder.AddPoint(
        where, static_cast<std::int64_t>(id), {position[0], position[1], position[2]}, colour);
  }
  at.RequireEnd();
}

// Words of a text file's lines, without those that begin with #.
class TextLines {
 public:
  explicit TextLines(const fs::path& file) : file_(file.string()), bytes_(ReadWholeFile(file)) {}

  // False at the end of the file. A line of observations may be empty: it then has no words.
  bool Next(bool may_be_empty = false) {
    while (at_ < bytes_.size()) {
      const char* begin = reinterpret_cast<const char*>(bytes_.data()) + at_;
      const std::string_view rest(begin, bytes_.size() - at_);
      rest_ = rest.substr(0, rest.find('\n'));
      at_ += std::min(rest_.size() + 1, rest.size());
      ++line_;
      const bool is_empty = rest_.find_first_not_of(" \t\r") == std::string_view::npos;
      if (may_be_empty || !(is_empty || rest_.front() == '#')) return true;
    }
    return false;
  }
  bool HasWords() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    return !rest_.empty();
  }
  std::string_view Word(const char* what) {
    if (!HasWords()) {
      throw std::runtime_error(Where() + ": expected " + what + ", found the line's end");
    }
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(word.size());
    return word;
  }
  template <typename Number>
  Number Take(const char* what) {
    const std::string_view word = Word(what);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw std::runtime_error(Where() + ": expected " + what + ", found '" +
                               std::string(word.substr(0, 40)) + "'");
    }
    return value;
  }
  glm::dvec3 TakeVector(const char* what) {
    glm::dvec3 v;
    for (int c = 0; c < 3; ++c) v[c] = Take<double>(what);
    return v;
  }
  // The rest of the line: names may contain spaces.
  std::string Rest() {
    HasWords();
    return std::string(rest_.substr(0, rest_.find_last_not_of(" \t\r") + 1));
  }
  std::string Where() const { return file_ + ":" + std::to_string(line_); }

 private:
  std::string file_;
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  std::string_view rest_;
};

void ReadCamerasText(const fs::path& file, ReconstructionBuilder& builder) {
  TextLines lines(file);
  while (lines.Next()) {
    const auto id = lines.Take<std::uint32_t>("a camera's id");
    const std::string_view name = lines.Word("a camera's model");
    const auto* model = std::find_if(kCameraModels.begin(),
                                     kCameraModels.end(),
                                     [&](const CameraModel& known) { return known.name == name; });
    if (model == kCameraModels.end()) RefuseModel(lines.Where(), name.substr(0, 40));
    const int width = lines.Take<int>("a width in pixels");
    const int height = lines.Take<int>("a height in pixels");
    std::array<double, kMostParameters> parameters{};
    for (std::size_t p = 0; p < model->parameters; ++p) {
      parameters[p] = lines.Take<double>("a camera's parameter");
    }
    builder.AddCamera(lines.Where(),
                      std::to_string(id),
                      IntrinsicsOf(lines.Where(), model->name, width, height, parameters));
  }
}

void ReadImagesText(const fs::path& file, ReconstructionBuilder& builder) {
  TextLines lines(file);
  while (lines.Next()) {
    const std::string where = lines.Where();
    lines.Take<std::uint32_t>("a picture's id");
    std::array<double, 4> rotation{};
    for (double& q : rotation) q = lines.Take<double>("a rotation's quaternion");
    const glm::dvec3 translation = lines.TakeVector("a translation");
    const auto camera = lines.Take<std::uint32_t>("a camera's id");
    const std::string name = lines.Rest();
    std::vector<ReconstructionBuilder::Observed> observed;
    if (!lines.Next(true)) {
      throw std::runtime_error(where + ": expected a line with the picture's points after it");
    }
    while (lines.HasWords()) {
      const double x = lines.Take<double>("X of a point in the picture");
      const double y = lines.Take<double>("Y of a point in the picture");
      const auto point = lines.Take<std::int64_t>("the id of a point");
      if (point >= 0) observed.push_back({point, {x - 0.5, y - 0.5}});
    }
    builder.AddPicture(
        where, name, std::to_string(camera), PoseOf(rotation, translation), std::move(observed));
  }
}

void ReadPointsText(const fs::path& file, ReconstructionBuilder& builder) {
  TextLines lines(file);
  while (lines.Next()) {
    const auto id = lines.Take<std::int64_t>("a point's id");
    const glm::dvec3 position = lines.TakeVector("a coordinate");
    builder.AddPoint(lines.Where(), id, position, lines.TakeVector("a colour"));
  }
}

using Reader = void (*)(const fs::path&, ReconstructionBuilder&);

void ReadPart(const fs::path& folder,
              const std::string& part,
              Reader binary,
              Reader text,
              ReconstructionBuilder& builder) {
  std::error_code error;
  if (fs::exists(folder / (part + ".bin"), error)) {
    binary(folder / (part + ".bin"), builder);
  } else if (fs::exists(folder / (part + ".txt"), error)) {
    text(folder / (part + ".txt"), builder);
  } else {
    throw std::runtime_error((folder / (part + ".bin")).string() + ": expected COLMAP's file, or " +
                             part + ".txt, found neither");
  }
}

}  // namespace

Reconstruction ReadColmap(const fs::path& folder) {
  ReconstructionBuilder builder;
  ReadPart(folder, "cameras", ReadCamerasBinary, ReadCamerasText, builder);
  ReadPart(folder, "points3D", ReadPointsBinary, ReadPointsText, builder);
  ReadPart(folder, "images", ReadImagesBinary, ReadImagesText, builder);
  return builder.Finish(folder.string());
}

}  // namespace pleinair
