// sequence.json in: every key checked for presence, type and range.
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/json_cursor.h"
#include "datasets/camera_file.h"
#include "datasets/fisheye_setup.h"
#include "datasets/internal/json_vectors.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

constexpr std::size_t kAnyCount = static_cast<std::size_t>(-1);
constexpr int kMaxImageSidePx = 65536;
// Poses are written with six digits or more.
constexpr double kRigidTolerance = 1e-5;

glm::dvec2 ReadVector2(const JsonCursor& at) {
  const auto entries = at.List(2, 2);
  return {entries[0].Number(), entries[1].Number()};
}

// Row-major in the file, columns in glm.
glm::dmat4 ReadAffine(const JsonCursor& at) {
  glm::dmat4 matrix(1.0);
  const auto rows = at.List(4, 4);
  for (int row = 0; row < 4; ++row) {
    const auto entries = rows[row].List(4, 4);
    for (int column = 0; column < 4; ++column) matrix[column][row] = entries[column].Number();
    if (row == 3 && glm::dvec4(matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]) !=
                        glm::dvec4(0.0, 0.0, 0.0, 1.0)) {
      rows[row].Fail("the row 0, 0, 0, 1");
    }
  }
  return matrix;
}

glm::dmat4 ReadRigid(const JsonCursor& at) {
  const glm::dmat4 matrix = ReadAffine(at);
  const glm::dmat3 rotation(matrix);
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  double deviation = 0.0;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      deviation = std::max(deviation, std::abs(product[c][r] - (c == r ? 1.0 : 0.0)));
    }
  }
  if (!(deviation <= kRigidTolerance)) at.Fail("a rigid transform (rotation and translation)");
  if (!(glm::determinant(rotation) > 0.0)) at.Fail("a rotation, not a mirror image");
  return matrix;
}

glm::dmat4 ReadInvertible(const JsonCursor& at) {
  const glm::dmat4 matrix = ReadAffine(at);
  const glm::dmat3 linear(matrix);
  // Relative to the volume that the columns' lengths would span: scale does not matter.
  const double volume = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  if (!(std::abs(glm::determinant(linear)) > 1e-9 * volume)) at.Fail("an invertible transform");
  return matrix;
}

UtcTime ReadTime(const JsonCursor& at) {
  try {
    return ParseUtcTime(at.Text());
  } catch (const std::invalid_argument&) {
    at.Fail("a UTC time such as 2005-06-21T09:50:00.25Z");
  }
}

std::vector<std::string> ReadTexts(const JsonCursor& at) {
  std::vector<std::string> texts;
  for (const JsonCursor& entry : at.List(0, kAnyCount)) texts.push_back(entry.Text());
  return texts;
}

template <typename Read>
auto ReadOptional(const JsonCursor& at, std::string_view key, const Read& read)
    -> std::optional<decltype(read(at))> {
  const auto found = at.Optional(key);
  if (!found) return std::nullopt;
  return read(*found);
}

// Bounds of what floats hold with room to spare, so that no product of these over- or underflows.
double ReadExposure(const JsonCursor& at) { return at.NumberIn(1e-30, 1e30); }
double ReadCameraSetting(const JsonCursor& at) { return at.NumberIn(1e-9, 1e9); }

CameraIntrinsics ReadIntrinsics(const JsonCursor& at) {
  at.CheckKeys({"width",
                "height",
                "fx",
                "fy",
                "cx",
                "cy",
                "distortion",
                "distortion_model",
                "pixel_centers",
                "camera_from_world"});
  CameraIntrinsics camera;
  camera.width_px = at.Required("width").IntegerIn(1, kMaxImageSidePx);
  camera.height_px = at.Required("height").IntegerIn(1, kMaxImageSidePx);
  camera.fx_px = at.Required("fx").PositiveNumber();
  camera.fy_px = at.Required("fy").PositiveNumber();
  camera.cx_px = at.Required("cx").NumberIn(-1e6, 1e6);
  camera.cy_px = at.Required("cy").NumberIn(-1e6, 1e6);
  if (const auto distortion = at.Optional("distortion")) {
    const auto coefficients = distortion->List(5, 5);
    for (std::size_t i = 0; i < 5; ++i) camera.distortion[i] = coefficients[i].Number();
  }
  if (const auto model = at.Optional("distortion_model")) model->OneOf({"opencv"});
  if (const auto centers = at.Optional("pixel_centers")) centers->OneOf({"integer"});
  return camera;
}

class SequenceReader {
 public:
  SequenceReader(const std::filesystem::path& file,
                 SequencePoses poses,
                 std::optional<Weather> weather)
      : folder_(file.parent_path()), poses_(poses), weather_(weather) {
    sequence_.folder = folder_;
    sequence_.file = file;
  }

  Sequence Read(const JsonCursor& root) {
    ReadPlace(root);
    ReadFrames(root);
    if (weather_) {
      sequence_.weather = weather_;
      for (FrameEntry& frame : sequence_.frames) frame.weather.reset();
    }
    CheckSunIsKnown();
    return std::move(sequence_);
  }

  // Without frames but the one that says where the camera stands.
  Sequence ReadSite(const JsonCursor& root, UtcTime time) {
    ReadPlace(root);
    // Weather is of the day that was recorded.
    sequence_.weather = weather_;
    if (root.Optional("frames") && !sequence_.camera_from_world) {
      ReadFrames(root);
      sequence_.camera_from_world = sequence_.frames.front().camera_from_world;
      sequence_.frames.clear();
    }
    sequence_.frames.emplace_back().time = time;
    if (!sequence_.camera_from_world && poses_ == SequencePoses::kRequired) {
      root.Required("camera").FailMissing("camera_from_world",
                                          "where the camera stands (or --markers)");
    }
    CheckSunIsKnown();
    return std::move(sequence_);
  }

 private:
  // All but the frames.
  void ReadPlace(const JsonCursor& root) {
    const bool is_site =
        root.Required("format").OneOf({"pleinair-sequence", "pleinair-site"}) == "pleinair-site";
    root.Required("version").IntegerIn(1, 1);
    root.CheckKeys({"format",
                    "version",
                    "site",
                    "weather",
                    "camera",
                    "camera_device",
                    "radiometry",
                    "scene",
                    "windows",
                    "diffuse_regions",
                    "diffuse_mask",
                    "environment",
                    "fisheye",
                    "virtual_object",
                    "virtual_objects",
                    "frames"});
    for (const char* key : {"weather", "frames"}) {
      const auto of_a_recording = root.Optional(key);
      if (is_site && of_a_recording) of_a_recording->Fail("a site, which has no such key");
    }
    if (const auto name = root.Optional("name")) sequence_.name = name->FreeText();
    if (sequence_.name.empty()) sequence_.name = DefaultName();
    if (const auto at = root.Optional("site")) ReadSite(*at);
    sequence_.weather = ReadOptional(root, "weather", ReadWeather);
    const JsonCursor camera = root.Required("camera");
    sequence_.intrinsics = ReadIntrinsics(camera);
    sequence_.camera_from_world = ReadOptional(camera, "camera_from_world", ReadRigid);
    if (const auto at = root.Optional("camera_device")) sequence_.camera_device = at->Text();
    if (const auto at = root.Optional("radiometry")) ReadRadiometry(*at);
    ReadScene(root.Required("scene"));
    if (const auto at = root.Optional("windows")) ReadWindows(*at);
    if (const auto at = root.Optional("diffuse_regions")) {
      sequence_.diffuse_regions = ReadTexts(*at);
    }
    if (const auto at = root.Optional("diffuse_mask")) sequence_.diffuse_mask = ExistingFile(*at);
    if (const auto at = root.Optional("environment")) ReadEnvironment(*at);
    if (const auto at = root.Optional("fisheye")) sequence_.fisheye = ReadFisheye(*at);
    ReadVirtualObjects(root);
  }

  std::string DefaultName() const {
    std::error_code error;
    return std::filesystem::canonical(folder_, error).filename().string();
  }

  std::filesystem::path PathInside(const JsonCursor& at) const {
    const std::string text = at.Text();
    const auto inside = ResolveInside(folder_, text);
    if (!inside) at.Fail(inside.error());
    return std::filesystem::path(text).lexically_normal();
  }

  std::filesystem::path ExistingFile(const JsonCursor& at) const {
    std::filesystem::path path = PathInside(at);
    std::error_code error;
    if (!std::filesystem::is_regular_file(folder_ / path, error)) {
      at.Fail("the path of an existing file");
    }
    return path;
  }

  void ReadSite(const JsonCursor& at) {
    at.CheckKeys({"latitude_deg", "longitude_deg", "height_m", "north_uncertain_deg"});
    Site& site = sequence_.site.emplace();
    site.latitude_rad = RadFromDeg(at.Required("latitude_deg").NumberIn(-90.0, 90.0));
    site.longitude_rad = RadFromDeg(at.Required("longitude_deg").NumberIn(-360.0, 360.0));
    // From below the lowest shore to the highest orbits that cameras have worked in.
    site.height_m = at.Required("height_m").NumberIn(-1000.0, 1e6);
    if (const auto uncertain = at.Optional("north_uncertain_deg")) {
      sequence_.north_stddev_rad = RadFromDeg(uncertain->NumberIn(0.0, 180.0));
    }
  }

  void ReadRadiometry(const JsonCursor& at) {
    at.CheckKeys({"frames", "frames_ldr"});
    if (const auto frames = at.Optional("frames")) frames->OneOf({"linear"});
    if (const auto ldr = at.Optional("frames_ldr")) {
      const bool srgb = ldr->Text() == "srgb8";
      sequence_.response_ldr = srgb ? "srgb8" : ExistingFile(*ldr).string();
    }
  }

  void ReadScene(const JsonCursor& at) {
    at.CheckKeys({"mesh", "albedos_known", "albedos_assumed"});
    sequence_.scene_mesh = ExistingFile(at.Required("mesh"));
    if (const auto known = at.Optional("albedos_known")) sequence_.albedos_known = known->Boolean();
    if (const auto assumed = at.Optional("albedos_assumed")) {
      sequence_.albedos_assumed = assumed->Boolean();
    }
  }

  void ReadWindows(const JsonCursor& at) {
    for (const JsonCursor& window : at.List(0, kAnyCount)) {
      window.CheckKeys({"polygon_world_m"});
      WindowEntry entry;
      if (const auto name = window.Optional("name")) entry.name = name->FreeText();
      for (const JsonCursor& corner : window.Required("polygon_world_m").List(3, kAnyCount)) {
        entry.polygon_world_m.push_back(ReadVector3(corner));
      }
      sequence_.windows.push_back(std::move(entry));
    }
  }

  void ReadEnvironment(const JsonCursor& at) {
    at.CheckKeys({"image", "position_m", "time_utc", "sun_direction_enu", "mapping"});
    const auto sun = ReadOptional(at, "sun_direction_enu", ReadDirection);
    if (const auto mapping = at.Optional("mapping")) CheckMapping(*mapping);
    const auto image = at.Optional("image");
    if (!image) {
      // Position and time have no use without a map; the sun may still be stated here.
      if (!sun) at.Fail("an object with `image` or `sun_direction_enu`");
      sequence_.sun_direction_enu = sun;
      return;
    }
    EnvironmentEntry entry;
    entry.image = ExistingFile(*image);
    entry.position_m = ReadVector3(at.Required("position_m"));
    entry.time = ReadTime(at.Required("time_utc"));
    entry.sun_direction_enu = sun;
    sequence_.environment = std::move(entry);
  }

  // A map that says it is laid out differently from scene/lat_long.h would be read turned or
  // mirrored.
  static void CheckMapping(const JsonCursor& at) {
    at.CheckKeys({"type", "up", "center", "right"});
    if (const auto type = at.Optional("type")) type->OneOf({"equirectangular"});
    if (const auto up = at.Optional("up")) up->OneOf({"+Z", "+Z (up)", "+Z up"});
    if (const auto center = at.Optional("center")) {
      center->OneOf({"+Y (north)", "+Y north", "+Y", "north"});
    }
    if (const auto right = at.Optional("right")) {
      right->OneOf({"+X (east)", "+X east", "+X", "east"});
    }
  }

  // Throws at the key that does not go with the others, or with the calibration.
  void CheckFisheye(const JsonCursor& at, const FisheyeEntry& entry) const {
    try {
      MakeFisheyeSetup(entry, folder_);
    } catch (const JsonError&) {
      throw;  // Names the calibration file.
    } catch (const std::exception& error) {
      throw JsonError(sequence_.file.string() + ": " + at.Path() + "." + error.what());
    }
  }

  FisheyeEntry ReadFisheye(const JsonCursor& at) const {
    at.CheckKeys({"model",
                  "fov_deg",
                  "width",
                  "height",
                  "up",
                  "image_up",
                  "image_right",
                  "position_m",
                  "calibration"});
    FisheyeEntry entry;
    entry.model =
        at.Required("model").OneOf({"equidistant", "equisolid", "stereographic", "opencv"});
    const auto fov = at.Required("fov_deg");
    entry.fov_deg = fov.PositiveNumber();
    if (entry.fov_deg > 360.0) fov.Fail("an angle of at most 360 degrees");
    entry.width_px = at.Required("width").IntegerIn(1, kMaxImageSidePx);
    entry.height_px = at.Required("height").IntegerIn(1, kMaxImageSidePx);
    if (const auto up = at.Optional("up")) entry.up = up->Text();
    if (const auto up = at.Optional("image_up")) entry.image_up = up->Text();
    if (const auto right = at.Optional("image_right")) entry.image_right = right->Text();
    entry.position_m = ReadOptional(at, "position_m", ReadVector3);
    if (const auto calibration = at.Optional("calibration")) {
      entry.calibration = ExistingFile(*calibration);
    } else if (entry.model == "opencv") {
      at.Required("calibration");
    }
    CheckFisheye(at, entry);
    return entry;
  }

  VirtualObjectEntry ReadVirtualObject(const JsonCursor& at) const {
    at.CheckKeys({"mesh", "world_from_object"});
    VirtualObjectEntry entry;
    entry.mesh = ExistingFile(at.Required("mesh"));
    entry.world_from_object = ReadInvertible(at.Required("world_from_object"));
    return entry;
  }

  void ReadVirtualObjects(const JsonCursor& root) {
    const auto one = root.Optional("virtual_object");
    const auto several = root.Optional("virtual_objects");
    if (one && several) several->Fail("only one of `virtual_object` and `virtual_objects`");
    if (one) sequence_.virtual_objects.push_back(ReadVirtualObject(*one));
    if (!several) return;
    // Surfaces that coincide are never visible, and each ray that meets them tests all of them:
    // time would grow with the square of their number.
    std::map<std::pair<std::filesystem::path, std::array<double, 16>>, std::string> known;
    for (const JsonCursor& at : several->List(0, kAnyCount)) {
      VirtualObjectEntry entry = ReadVirtualObject(at);
      std::array<double, 16> place{};
      for (std::size_t i = 0; i < place.size(); ++i) {
        place[i] = entry.world_from_object[static_cast<int>(i / 4)][static_cast<int>(i % 4)];
      }
      const auto [same, is_new] = known.try_emplace({entry.mesh, place}, at.Path());
      if (!is_new) at.Fail("a mesh or a place of its own, other than those of " + same->second);
      sequence_.virtual_objects.push_back(std::move(entry));
    }
  }

  static Weather ReadWeather(const JsonCursor& at) {
    return WeatherNamed(at.OneOf({"overcast", "broken", "clear"})).value();
  }

  static SamplePolygon ReadSamplePolygon(const JsonCursor& at) {
    at.CheckKeys({"material", "group", "sun", "polygon_px"});
    SamplePolygon polygon;
    polygon.material = at.Required("material").Text();
    polygon.group = at.Required("group").Text();
    polygon.sun = JudgedSunNamed(at.Required("sun").OneOf({"lit", "shaded", "grazing"})).value();
    for (const JsonCursor& corner : at.Required("polygon_px").List(3, kAnyCount)) {
      polygon.polygon_px.push_back(ReadVector2(corner));
    }
    return polygon;
  }

  RawImageEntry ReadRaw(const JsonCursor& at) const {
    at.CheckKeys(
        {"image", "format", "stride_bytes", "black_level", "white_level", "white_balance_rgb"});
    RawImageEntry raw;
    raw.image = PathInside(at.Required("image"));
    const JsonCursor format = at.Required("format");
    const std::optional<PixelFormat> named = PixelFormatNamed(format.Text());
    if (!named || named->coding != PixelCoding::kBayer) format.Fail("a Bayer format: SRGGB10");
    raw.format = *named;
    raw.stride_bytes = at.Required("stride_bytes").IntegerIn(1, 4 * kMaxImageSidePx);
    raw.development.black_level = at.Required("black_level").Number();
    raw.development.white_level = at.Required("white_level").Number();
    raw.development.white_balance_rgb = ReadVector3(at.Required("white_balance_rgb"));
    try {
      raw.development.Validate();
    } catch (const std::invalid_argument& error) {
      throw JsonError(sequence_.file.string() + ": " + at.Path() + ": " + error.what());
    }
    return raw;
  }

  FrameEntry ReadFrame(const JsonCursor& at) const {
    at.CheckKeys({"image",
                  "image_ldr",
                  "video_frame",
                  "raw",
                  "fisheye",
                  "time_utc",
                  "exposure",
                  "exposure_s",
                  "iso",
                  "f_number",
                  "camera_from_world",
                  "sun_direction_enu",
                  "weather",
                  "sample_polygons"});
    const auto path_inside = [this](const JsonCursor& path) { return PathInside(path); };
    FrameEntry entry;
    entry.image = ReadOptional(at, "image", path_inside);
    entry.image_ldr = ReadOptional(at, "image_ldr", path_inside);
    if (const auto frame = at.Optional("video_frame")) {
      if (!entry.image_ldr) frame->Fail("a video under `image_ldr`");
      entry.video_frame = frame->IntegerIn(0, std::numeric_limits<int>::max());
    }
    if (const auto raw = at.Optional("raw")) {
      if (entry.image || entry.image_ldr) raw->Fail("no `image` or `image_ldr` beside it");
      entry.raw = ReadRaw(*raw);
    }
    if (!entry.image && !entry.image_ldr && !entry.raw) {
      at.Fail("an object with `image`, `image_ldr` or `raw`");
    }
    entry.fisheye = ReadOptional(at, "fisheye", path_inside);
    if (entry.fisheye && !sequence_.fisheye) {
      at.Required("fisheye").Fail("a fish-eye image only where the sequence has `fisheye`");
    }
    entry.time = ReadTime(at.Required("time_utc"));
    entry.exposure = ReadOptional(at, "exposure", ReadExposure);
    entry.exposure_s = ReadOptional(at, "exposure_s", ReadCameraSetting);
    entry.iso = ReadOptional(at, "iso", ReadCameraSetting);
    entry.f_number = ReadOptional(at, "f_number", ReadCameraSetting);
    entry.camera_from_world = ReadOptional(at, "camera_from_world", ReadRigid);
    if (!entry.camera_from_world && !sequence_.camera_from_world &&
        poses_ == SequencePoses::kRequired) {
      at.FailMissing("camera_from_world",
                     "the frame's pose (or camera.camera_from_world, or --markers)");
    }
    entry.sun_direction_enu = ReadOptional(at, "sun_direction_enu", ReadDirection);
    entry.weather = ReadOptional(at, "weather", ReadWeather);
    if (const auto polygons = at.Optional("sample_polygons")) {
      for (const JsonCursor& polygon : polygons->List(0, kAnyCount)) {
        entry.sample_polygons.push_back(ReadSamplePolygon(polygon));
      }
    }
    return entry;
  }

  void ReadFrames(const JsonCursor& root) {
    const JsonCursor at = root.Required("frames");
    if (at.Value().is_string()) return ReadFrameLines(at);
    for (const JsonCursor& entry : at.List(1, kAnyCount)) {
      sequence_.frames.push_back(ReadFrame(entry));
    }
  }

  void ReadFrameLines(const JsonCursor& at) {
    const std::filesystem::path file = folder_ / ExistingFile(at);
    std::ifstream lines(file, std::ios::binary);
    std::string line;
    // The end of the file ends no line.
    for (int number = 1; std::getline(lines, line) && !lines.eof(); ++number) {
      const std::string label = file.string() + ":" + std::to_string(number);
      const nlohmann::json entry = ParseJson(line, label);
      sequence_.frames.push_back(ReadFrame(JsonCursor(entry, label)));
    }
    if (lines.bad() || !lines.eof()) throw JsonError(file.string() + ": cannot be read");
    if (sequence_.frames.empty())
      throw JsonError(file.string() +
                      ": expected a frame a line, found none: no picture was recorded");
  }

  // A fish-eye camera and a survey map may show the sun; a photograph does not.
  void CheckSunIsKnown() const {
    if (sequence_.site || sequence_.fisheye || sequence_.environment) return;
    for (std::size_t i = 0; i < sequence_.frames.size(); ++i) {
      if (sequence_.StatedSunDirectionEnu(i) || sequence_.WeatherOfFrame(i) == Weather::kOvercast) {
        continue;
      }
      const std::string frame = "frames[" + std::to_string(i) + "]";
      std::string message = sequence_.file.string();
      message += ": site: expected latitude_deg, longitude_deg and height_m, or ";
      message += frame + ".sun_direction_enu, or \"overcast\" as ";
      message += frame + ".weather: nothing says where the sun is";
      throw JsonError(message);
    }
  }

  std::filesystem::path folder_;
  SequencePoses poses_;
  std::optional<Weather> weather_;
  Sequence sequence_;
};

namespace fs = std::filesystem;

bool LooksLikeFrames(const fs::path& file) {
  const std::string content = DescribeContent(file);
  return content.find("picture") != std::string::npos || content.ends_with("video");
}

// The first file of a folder that is a picture or a video, by name; empty where there is none.
fs::path PictureIn(const fs::path& folder) {
  constexpr int kFilesLookedAt = 1000;
  std::set<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && entry.file_size(error) > 0) files.insert(entry.path());
    if (files.size() == kFilesLookedAt) break;
  }
  for (const fs::path& file : files) {
    if (LooksLikeFrames(file)) return file;
  }
  return {};
}

// `folder`/sequence.json. Throws, with what to do, where somebody has given something else.
fs::path SequenceFileIn(const fs::path& folder) {
  static const std::string kWhatItIs =
      "a sequence is a folder with frames and a sequence.json that names camera, mesh and each "
      "frame's time (see docs/sequences.md)";
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    const std::string expected = folder.string() + ": expected a sequence's folder, found ";
    if (!fs::is_regular_file(folder, error) || fs::file_size(folder, error) == 0) {
      throw JsonError(expected + (fs::exists(folder, error) ? "something else" : "nothing"));
    }
    const std::string content = DescribeContent(folder);
    if (content.ends_with("video")) {
      throw JsonError(expected + content + ": " + kWhatItIs +
                      "; `ffmpeg -i VIDEO frames/%06d.png` takes frames out of a video");
    }
    if (folder.filename() == "sequence.json") throw JsonError(expected + "the file in it");
    throw JsonError(expected + content + ": " + kWhatItIs);
  }
  fs::path file = folder / "sequence.json";
  if (!fs::exists(file, error)) {
    for (const char* still : {"panorama.json", "relight.json"}) {
      if (!fs::exists(folder / still, error)) continue;
      throw JsonError((folder / still).string() +
                      ": expected a sequence (sequence.json), found a still, which this version "
                      "does not handle");
    }
    if (const fs::path picture = PictureIn(folder); !picture.empty()) {
      throw JsonError(file.string() + ": expected a JSON file, found nothing but files such as " +
                      picture.filename().string() + " (" + DescribeContent(picture) +
                      "): " + kWhatItIs);
    }
  }
  if (!ResolveInside(folder, "sequence.json")) {
    throw JsonError(file.string() + ": expected a file inside the sequence's folder");
  }
  return file;
}

void CheckFormat(const JsonCursor& root) {
  if (!root.Value().is_object()) root.Fail("an object");
  const auto format = root.Optional("format");
  if (!format) return;
  if (format->Value() == "pleinair-panorama" || format->Value() == "pleinair-relight") {
    format->Fail("\"pleinair-sequence\" (stills are not handled by this version)");
  }
  format->OneOf({"pleinair-sequence", "pleinair-site"});
}

Sequence ReadWith(const fs::path& file, const std::function<Sequence(const JsonCursor&)>& read) {
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  CheckFormat(root);
  return read(root);
}

}  // namespace

Sequence ReadSequence(const std::filesystem::path& folder,
                      SequencePoses poses,
                      std::optional<Weather> weather) {
  const fs::path file = SequenceFileIn(folder);
  return ReadWith(file, [&](const JsonCursor& root) {
    root.Required("format").OneOf({"pleinair-sequence"});
    return SequenceReader(file, poses, weather).Read(root);
  });
}

Sequence ReadSite(const std::filesystem::path& folder,
                  UtcTime time,
                  SequencePoses poses,
                  std::optional<Weather> weather) {
  std::error_code error;
  const fs::path site = folder / "site.json";
  const bool is_site = fs::exists(site, error);
  if (is_site && !ResolveInside(folder, "site.json")) {
    throw JsonError(site.string() + ": expected a file inside the site's folder");
  }
  const fs::path file = is_site ? site : SequenceFileIn(folder);
  return ReadWith(file, [&](const JsonCursor& root) {
    return SequenceReader(file, poses, weather).ReadSite(root, time);
  });
}

StatedCamera ReadStatedCamera(const std::filesystem::path& file_or_folder) {
  std::error_code error;
  fs::path file = CameraFileIn(file_or_folder);
  if (fs::is_directory(file_or_folder, error) && file.filename() != "site.json") {
    file = SequenceFileIn(file_or_folder);
  }
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  CheckFormat(root);
  const JsonCursor camera = root.Required("camera");
  return {ReadIntrinsics(camera), ReadOptional(camera, "camera_from_world", ReadRigid)};
}

CameraIntrinsics ReadCameraIntrinsics(const std::filesystem::path& file_or_folder) {
  return ReadStatedCamera(file_or_folder).intrinsics;
}

}  // namespace pleinair
