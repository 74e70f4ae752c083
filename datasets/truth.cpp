#include "datasets/truth.h"

#include <cmath>
#include <cstdio>
#include <set>
#include <string>

#include <glm/geometric.hpp>

#include "calib/json_cursor.h"
#include "datasets/internal/json_vectors.h"
#include "datasets/internal/sequence_folder.h"

namespace pleinair {
namespace {

glm::dvec3 ReadRgb(const JsonCursor& at) {
  const auto channels = at.List(3, 3);
  glm::dvec3 rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = channels[c].NumberIn(0.0, 1e30);
  return rgb;
}

std::filesystem::path NameOf(const Sequence& sequence) {
  return sequence.folder / "truth" / "truth.json";
}

std::filesystem::path FileOf(const Sequence& sequence) {
  std::filesystem::path file = NameOf(sequence);
  if (!HasTruth(sequence)) throw JsonError(file.string() + ": expected the truth, found no file");
  if (!ResolveInside(sequence.folder, "truth/truth.json")) {
    throw JsonError(file.string() + ": expected a file inside the sequence's folder");
  }
  return file;
}

// The file that `key` names, or else the one under its usual name where that exists.
std::optional<std::filesystem::path> Picture(const Sequence& sequence,
                                             const JsonCursor& at,
                                             const char* key,
                                             const char* usual_name,
                                             int frame) {
  const std::filesystem::path truth = "truth";
  if (const auto named = at.Optional(key)) {
    const auto inside = ResolveInside(sequence.folder, truth / named->Text());
    if (!inside) named->Fail(inside.error());
    return *inside;
  }
  char name[64];
  std::snprintf(name, sizeof(name), usual_name, frame);
  const auto inside = ResolveInside(sequence.folder, truth / name);
  std::error_code error;
  if (!inside || !std::filesystem::is_regular_file(*inside, error)) return std::nullopt;
  return *inside;
}

}  // namespace

bool HasTruth(const Sequence& sequence) {
  std::error_code error;
  return std::filesystem::exists(NameOf(sequence), error);
}

std::vector<TruthFrame> ReadTruth(const Sequence& sequence) {
  const std::filesystem::path file = FileOf(sequence);
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  std::vector<TruthFrame> frames;
  std::set<int> seen;
  for (const JsonCursor& at : root.Required("frames").List(1, sequence.frames.size())) {
    TruthFrame frame;
    const JsonCursor number = at.Required("frame");
    frame.frame = number.IntegerIn(0, static_cast<int>(sequence.frames.size()) - 1);
    if (!seen.insert(frame.frame).second) number.Fail("each frame once");
    frame.sun_direction_enu = ReadDirection(at.Required("sun_direction_enu"));
    frame.sun_irradiance_rgb = ReadRgb(at.Required("sun_irradiance_rgb"));
    frame.sky_irradiance_rgb = ReadRgb(at.Required("sky_irradiance_rgb"));
    frame.with_object = Picture(sequence, at, "with_object", "with_object/%06d.exr", frame.frame);
    frame.with_object_ldr =
        Picture(sequence, at, "with_object_ldr", "with_object_ldr/%06d.png", frame.frame);
    frame.coverage = Picture(sequence, at, "coverage", "masks/coverage_%06d.png", frame.frame);
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::map<std::string, glm::dvec3> ReadTrueAlbedos(const Sequence& sequence) {
  const std::filesystem::path file = FileOf(sequence);
  const nlohmann::json document = LoadJson(file);
  std::map<std::string, glm::dvec3> albedos;
  if (const auto materials = JsonCursor(document, file.string()).Optional("materials")) {
    for (const auto& [name, unused] : materials->Value().items()) {
      const auto albedo = materials->Required(name).Optional("mean_albedo_rgb");
      if (albedo) albedos.emplace(name, ReadRgb(*albedo));
    }
  }
  if (albedos.empty()) {
    throw JsonError(file.string() + ": materials: expected the mean_albedo_rgb of some");
  }
  return albedos;
}

}  // namespace pleinair
