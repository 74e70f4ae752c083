#include "apps/viewer/snapshot.h"

#include <chrono>
#include <stdexcept>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/effect_names.h"
#include "apps/lighting_log.h"
#include "apps/viewer/object_editor.h"
#include "datasets/diffuse_mask.h"
#include "datasets/recording/site_files.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

constexpr const char* kSkyImage = "sky.exr";

// A name that no folder has yet.
std::filesystem::path FreeFolder(const std::filesystem::path& out, UtcTime time) {
  const std::string name =
      fmt::format("snapshot-{:%Y%m%d-%H%M%S}",
                  fmt::gmtime(std::chrono::system_clock::to_time_t(
                      std::chrono::time_point_cast<std::chrono::system_clock::duration>(time))));
  std::filesystem::path folder = out / name;
  for (int n = 2; std::filesystem::exists(folder); ++n)
    folder = out / fmt::format("{}-{}", name, n);
  return folder;
}

// The frame alone, with its pictures as files of the snapshot.
FrameEntry WriteFrame(const Sequence& sequence,
                      bool is_of_sequence,
                      const Frame& frame,
                      const std::filesystem::path& folder) {
  FrameEntry entry;
  if (is_of_sequence) entry = sequence.frames[static_cast<std::size_t>(frame.index)];
  entry.video_frame.reset();
  entry.raw.reset();
  entry.image.reset();
  entry.image_ldr.reset();
  entry.time = frame.time;
  entry.camera_from_world = frame.camera.camera_from_world;
  entry.sun_direction_enu = frame.sun_direction_enu;
  entry.weather = frame.weather;
  if (frame.codes) {
    entry.image_ldr = "frame.png";
    WritePng(folder / *entry.image_ldr, *frame.codes);
  } else {
    entry.image = "frame.exr";
    WriteExr(folder / *entry.image, frame.radiance, ExrPrecision::kFloat);
  }
  if (entry.fisheye) {
    const std::filesystem::path from = sequence.folder / *entry.fisheye;
    entry.fisheye = "fisheye" + from.extension().string();
    std::filesystem::copy_file(from, folder / *entry.fisheye);
  }
  // A camera's relative exposure is its time at ISO 100 and f/1.
  if (!is_of_sequence && frame.exposure) {
    constexpr double kIso = 100.0;
    entry.exposure_s = *frame.exposure / kIso;
    entry.iso = kIso;
    entry.f_number = 1.0;
  }
  return entry;
}

// The sun's place follows from the sequence, as for the composite. If it were stated to the last
// digit, it would have a transport of its own, not that of the frame's step of time.
std::string LineWithoutPlaceOfSun(const std::string& line) {
  auto json = nlohmann::ordered_json::parse(line);
  json.erase("sun_direction_enu");
  return json.dump() + "\n";
}

void CopySite(const Sequence& sequence, const std::filesystem::path& folder) {
  for (const std::filesystem::path& file : SiteFiles(sequence.folder, folder)) {
    std::filesystem::create_directories((folder / file).parent_path());
    std::filesystem::copy_file(sequence.folder / file, folder / file);
  }
}

std::string EffectsText(const EffectSettings& effects) {
  std::string names;
  for (const Effect effect : kAllEffects) {
    if (effects[effect] == EffectSwitch::kOff) names += fmt::format(",no-{}", NameOf(effect));
    if (effects[effect] == EffectSwitch::kOn) names += fmt::format(",{}", NameOf(effect));
  }
  return "plan" + names;
}

void Fill(const ViewedSite& site,
          const ViewedFrame& viewed,
          const SnapshotChoices& choices,
          const std::filesystem::path& folder) {
  const Sequence& sequence = site.loaded->sequence;
  const Frame& frame = viewed.step.frame.value();
  const FrameResult& result = viewed.step.result.value();
  CopySite(sequence, folder);
  Sequence alone = sequence;
  // A camera's pictures may have another size than the site's, whose mask is then none for them.
  alone.intrinsics = frame.camera.intrinsics;
  if (!(alone.intrinsics == sequence.intrinsics)) {
    if (const auto mask = ReadDiffuseMask(sequence); mask && !mask->is_over_map) {
      alone.diffuse_mask.reset();
    }
  }
  alone.frames = {WriteFrame(sequence, sequence.HasPictures(), frame, folder)};
  alone.virtual_objects.clear();
  WriteSequence(alone, folder);
  SaveObjectsWithFiles(folder / "sequence.json", choices.objects);

  if (viewed.sky) WriteExr(folder / kSkyImage, *viewed.sky, ExrPrecision::kFloat);
  Frame first = frame;
  first.index = 0;
  WriteWholeText(folder / "lighting.jsonl",
                 LineWithoutPlaceOfSun(LightingLine(first, result, viewed.sky ? kSkyImage : "")));
  std::string settings;
  for (const std::string& setting : choices.settings) settings += setting + "\n";
  settings += fmt::format("pipeline.effects.threshold_code_values={}\n",
                          choices.effects.threshold_code_values);
  if (choices.effects.budget_ms) {
    settings += fmt::format("pipeline.effects.budget_ms={}\n", *choices.effects.budget_ms);
  }
  WriteWholeText(folder / "settings.txt", settings);
  WriteWholeText(
      folder / "run.txt",
      fmt::format("pleinair run . --lighting lighting.jsonl --settings settings.txt --effects {}{} "
                  "--out out\n",
                  EffectsText(choices.effects),
                  frame.codes ? " --frames ldr" : ""));
  // At another exposure it is not the picture that a run gives.
  WritePng(folder / (viewed.request.exposure_stops == 0.0 ? "composite.png" : "shown.png"),
           viewed.shown);
  WriteExr(folder / "composite.exr", result.composite.radiance, ExrPrecision::kHalf);
}

}  // namespace

std::filesystem::path WriteSnapshot(const ViewedSite& site,
                                    const ViewedFrame& frame,
                                    const SnapshotChoices& choices,
                                    const std::filesystem::path& out) {
  if (!frame.Succeeded()) throw std::runtime_error("snapshot: expected a frame that succeeded");
  std::filesystem::path folder = FreeFolder(out, frame.Time());
  const std::filesystem::path partial = folder.string() + ".part";
  try {
    MakeFolder(out);
    std::filesystem::remove_all(partial);
    std::filesystem::create_directory(partial);
    Fill(site, frame, choices, partial);
    std::filesystem::rename(partial, folder);
  } catch (const std::exception& error) {
    std::error_code ignored;
    std::filesystem::remove_all(partial, ignored);
    throw std::runtime_error("snapshot: " + std::string(error.what()));
  }
  return folder;
}

}  // namespace pleinair
