#include "datasets/scoring.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>

#include "datasets/frame_source.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "sunmodel/clear_sky.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

fs::path NumberedFile(const fs::path& folder, int frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06d.%s", frame, extension);
  return folder / name;
}

Frame ReadFrame(const Sequence& sequence, int frame, FrameKind kind) {
  Sequence one = sequence;
  one.frames = {sequence.frames.at(static_cast<std::size_t>(frame))};
  auto next = MakeRecordedFrameSource(one, kind)->Next();
  if (!*next) throw std::runtime_error(next->error().reason);
  return std::move(**next);
}

glm::dvec3 ClearBeam(const Sequence& sequence, const glm::dvec3& sun_direction_enu) {
  const double elevation_rad =
      std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
  return ComputeClearSky(sequence.site.value_or(Site{}), elevation_rad).beam_rgb;
}

// What the composites of one run are compared with.
class CompositeScorer {
 public:
  CompositeScorer(const Sequence& sequence, const Mesh& phantom, const fs::path& out)
      : sequence_(sequence), phantom_(phantom), out_(out) {
    for (const VirtualObjectEntry& entry : sequence.virtual_objects) {
      const LoadedMesh loaded = LoadMesh(sequence.folder / entry.mesh);
      objects_.push_back(TransformMesh(entry.world_from_object, loaded.mesh));
    }
  }

  // Throws std::exception with what is missing.
  void Score(const TruthFrame& truth, FrameScore& score) {
    if (!truth.with_object) throw std::runtime_error("no truth with the object");
    if (!truth.coverage) throw std::runtime_error("no truth of the object's coverage");
    const fs::path file = NumberedFile(out_ / "composite", truth.frame, "exr");
    if (!fs::exists(file)) throw std::runtime_error(file.string() + " is not there");
    const RgbImage composite = ReadRadianceImage(file);
    const RgbImage with_object = ReadRadianceImage(*truth.with_object);
    const Gray8Image coverage = ReadMaskImage(*truth.coverage);
    std::optional<Gray8Image> change;
    const fs::path mask = NumberedFile(out_ / "mask", truth.frame, "png");
    if (fs::exists(mask)) change = ReadMaskImage(mask);

    const FrameEntry& entry = sequence_.frames[static_cast<std::size_t>(truth.frame)];
    const Frame best = ReadFrame(sequence_, truth.frame, FrameKind::kLinear);
    if (!best.exposure) throw std::runtime_error("no exposure to show the composite at");
    std::optional<Frame> codes;
    score.made_from_linear = entry.image.has_value();
    if (entry.image && entry.image_ldr) {
      // The run does not say which kind it was made from; its untouched pixels do.
      Frame ldr = ReadFrame(sequence_, truth.frame, FrameKind::kLdr);
      if (CountIdenticalPixels(ldr.radiance, composite) >
          CountIdenticalPixels(best.radiance, composite)) {
        codes = std::move(ldr);
        score.made_from_linear = false;
      }
    }
    score.composite = ScoreComposite({codes ? codes->radiance : best.radiance,
                                      composite,
                                      best.radiance,
                                      with_object,
                                      coverage,
                                      change ? &*change : nullptr,
                                      Specular(best.camera),
                                      *best.exposure});
  }

 private:
  const Gray8Image* Specular(const Camera& camera) {
    if (!camera_ || !(*camera_ == camera)) {
      specular_ = SpecularPixels(objects_, phantom_, camera);
      camera_ = camera;
    }
    return specular_ ? &*specular_ : nullptr;
  }

  const Sequence& sequence_;
  RayCaster phantom_;
  fs::path out_;
  std::vector<Mesh> objects_;
  std::optional<Camera> camera_;
  std::optional<Gray8Image> specular_;
};

std::map<int, LightingRecord> RecordsByFrame(const fs::path& file, std::size_t frame_count) {
  std::map<int, LightingRecord> records;
  for (LightingRecord& record : ReadLightingRecords(file)) {
    if (static_cast<std::size_t>(record.frame) >= frame_count) {
      throw std::runtime_error(file.string() + ": expected frames of the sequence (0 to " +
                               std::to_string(frame_count - 1) + "), found frame " +
                               std::to_string(record.frame));
    }
    records[record.frame] = std::move(record);
  }
  return records;
}

LightSummaries Summarise(const std::vector<FrameScore>& frames,
                         std::optional<LightScore> FrameScore::*light) {
  std::vector<LightScore> all;
  std::vector<LightScore> well_posed;
  std::vector<LightScore> others;
  for (const FrameScore& frame : frames) {
    if (!(frame.*light)) continue;
    all.push_back(*(frame.*light));
    (frame.IsWellPosed() ? well_posed : others).push_back(*(frame.*light));
  }
  return {SummariseLight(all), SummariseLight(well_posed), SummariseLight(others)};
}

std::optional<Distribution> Summarise(const std::vector<FrameScore>& frames,
                                      std::optional<double> CompositeScore::*value) {
  std::vector<double> values;
  for (const FrameScore& frame : frames) {
    if (frame.composite && (*frame.composite).*value)
      values.push_back(*((*frame.composite).*value));
  }
  return DistributionOf(values);
}

CompositeSummary SummariseComposites(const std::vector<FrameScore>& frames) {
  return {Summarise(frames, &CompositeScore::object_psnr_db),
          Summarise(frames, &CompositeScore::object_psnr_without_specular_db),
          Summarise(frames, &CompositeScore::effect_psnr_db),
          Summarise(frames, &CompositeScore::identical_outside_mask),
          Summarise(frames, &CompositeScore::changed_of_unchanged)};
}

}  // namespace

Score ScoreRun(const fs::path& sequence_folder, const fs::path& out) {
  const Sequence sequence = ReadSequence(sequence_folder);
  const std::vector<TruthFrame> truth = ReadTruth(sequence);
  const std::map<int, LightingRecord> records =
      RecordsByFrame(out / "lighting.jsonl", sequence.frames.size());
  const Mesh phantom = LoadMesh(sequence.folder / sequence.scene_mesh).mesh;
  SunlitCounter sunlit(sequence, phantom);
  CompositeScorer composites(sequence, phantom, out);

  Score score;
  score.sequence = sequence.name;
  score.largest_true_sun = LargestTrueSun(truth);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    FrameScore frame;
    frame.frame = static_cast<int>(i);
    frame.time_utc = FormatUtcTime(sequence.frames[i].time);
    score.frames.push_back(std::move(frame));
  }
  std::vector<bool> has_truth(sequence.frames.size(), false);
  for (const TruthFrame& true_frame : truth) {
    const auto index = static_cast<std::size_t>(true_frame.frame);
    FrameScore& frame = score.frames[index];
    has_truth[index] = true;
    frame.sunlit = sunlit.Count(sequence.CameraOfFrame(index), true_frame.sun_direction_enu);
    const auto found = records.find(true_frame.frame);
    if (found == records.end()) {
      frame.without.push_back("light: lighting.jsonl has no line for it");
      continue;
    }
    const LightingRecord& record = found->second;
    if (record.error) {
      frame.without.push_back("all: the run failed on it: " + *record.error);
      continue;
    }
    const glm::dvec3 clear_beam = ClearBeam(sequence, true_frame.sun_direction_enu);
    frame.light = ScoreLight(record.light, true_frame, score.largest_true_sun, clear_beam);
    if (record.raw) {
      frame.raw = ScoreLight(*record.raw, true_frame, score.largest_true_sun, clear_beam);
    }
    if (!frame.light) frame.without.push_back("light: none in its line");
    if (!frame.raw) frame.without.push_back("raw light: none in its line");
    try {
      composites.Score(true_frame, frame);
    } catch (const std::exception& error) {
      frame.without.push_back(std::string("composite: ") + error.what());
    }
  }
  for (FrameScore& frame : score.frames) {
    if (!has_truth[static_cast<std::size_t>(frame.frame)]) frame.without.push_back("all: no truth");
  }
  score.light = Summarise(score.frames, &FrameScore::light);
  score.raw = Summarise(score.frames, &FrameScore::raw);
  score.composite = SummariseComposites(score.frames);
  return score;
}

}  // namespace pleinair
