#include "datasets/internal/frame_entries.h"

#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/internal/json_vectors.h"
#include "datasets/internal/sequence_values.h"

namespace pleinair {
namespace {

// Bounds of what floats hold with room to spare, so that no product of these over- or underflows.
double ReadExposure(const JsonCursor& at) { return at.NumberIn(1e-30, 1e30); }
double ReadCameraSetting(const JsonCursor& at) { return at.NumberIn(1e-9, 1e9); }

SamplePolygon ReadSamplePolygon(const JsonCursor& at) {
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

RawImageEntry ReadRaw(const JsonCursor& at, const FrameRules& rules) {
  at.CheckKeys(
      {"image", "format", "stride_bytes", "black_level", "white_level", "white_balance_rgb"});
  RawImageEntry raw;
  raw.image = ReadPathInside(at.Required("image"), rules.folder);
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
    throw JsonError(rules.file.string() + ": " + at.Path() + ": " + error.what());
  }
  return raw;
}

FrameEntry ReadFrame(const JsonCursor& at, const FrameRules& rules) {
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
  const auto path_inside = [&](const JsonCursor& path) {
    return ReadPathInside(path, rules.folder);
  };
  FrameEntry entry;
  entry.image = ReadOptional(at, "image", path_inside);
  entry.image_ldr = ReadOptional(at, "image_ldr", path_inside);
  if (const auto frame = at.Optional("video_frame")) {
    if (!entry.image_ldr) frame->Fail("a video under `image_ldr`");
    entry.video_frame = frame->IntegerIn(0, std::numeric_limits<int>::max());
  }
  if (const auto raw = at.Optional("raw")) {
    if (entry.image || entry.image_ldr) raw->Fail("no `image` or `image_ldr` beside it");
    entry.raw = ReadRaw(*raw, rules);
  }
  if (!entry.image && !entry.image_ldr && !entry.raw) {
    at.Fail("an object with `image`, `image_ldr` or `raw`");
  }
  entry.fisheye = ReadOptional(at, "fisheye", path_inside);
  if (entry.fisheye && !rules.have_fisheye) {
    at.Required("fisheye").Fail("a fish-eye image only where the sequence has `fisheye`");
  }
  entry.time = ReadTime(at.Required("time_utc"));
  entry.exposure = ReadOptional(at, "exposure", ReadExposure);
  entry.exposure_s = ReadOptional(at, "exposure_s", ReadCameraSetting);
  entry.iso = ReadOptional(at, "iso", ReadCameraSetting);
  entry.f_number = ReadOptional(at, "f_number", ReadCameraSetting);
  entry.camera_from_world = ReadOptional(at, "camera_from_world", ReadRigid);
  if (!entry.camera_from_world && rules.need_pose) {
    at.FailMissing("camera_from_world",
                   "the frame's pose (or camera.camera_from_world, or --markers or --poses)");
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

std::vector<FrameEntry> ReadFrameLines(const std::filesystem::path& file, const FrameRules& rules) {
  std::vector<FrameEntry> frames;
  std::ifstream lines(file, std::ios::binary);
  std::string line;
  // The end of the file ends no line.
  for (int number = 1; std::getline(lines, line) && !lines.eof(); ++number) {
    const std::string label = file.string() + ":" + std::to_string(number);
    const nlohmann::json entry = ParseJson(line, label);
    frames.push_back(ReadFrame(JsonCursor(entry, label), rules));
  }
  if (lines.bad() || !lines.eof()) throw JsonError(file.string() + ": cannot be read");
  if (frames.empty()) {
    throw JsonError(file.string() +
                    ": expected a frame a line, found none: no picture was recorded");
  }
  return frames;
}

}  // namespace

std::vector<FrameEntry> ReadFrameEntries(const JsonCursor& at, const FrameRules& rules) {
  if (at.Value().is_string()) {
    return ReadFrameLines(rules.folder / ReadExistingFile(at, rules.folder), rules);
  }
  std::vector<FrameEntry> frames;
  for (const JsonCursor& entry : at.List(1, kAnyCount)) frames.push_back(ReadFrame(entry, rules));
  return frames;
}

}  // namespace pleinair
