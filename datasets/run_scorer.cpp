#include "datasets/run_scorer.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "datasets/frame_source.h"
#include "datasets/truth.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "sunmodel/clear_sky.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

// A sequence's frames of one kind, by their numbers; opened with the first.
class Frames {
 public:
  Frames(Sequence sequence, FrameKind kind) : sequence_(std::move(sequence)), kind_(kind) {}
  // Throws std::runtime_error where the frame cannot be read.
  Frame Read(int index) {
    if (!source_) source_ = MakeRecordedFrameSource(sequence_, kind_);
    source_->Seek(index);
    auto next = source_->Next();
    if (!next) throw std::runtime_error("the sequence has no such frame");
    if (!*next) throw std::runtime_error(next->error().reason);
    return std::move(**next);
  }

 private:
  Sequence sequence_;
  FrameKind kind_;
  std::unique_ptr<FrameSource> source_;
};

std::map<int, TruthFrame> ByFrame(const std::vector<TruthFrame>& truth) {
  std::map<int, TruthFrame> by_frame;
  for (const TruthFrame& frame : truth) by_frame.emplace(frame.frame, frame);
  return by_frame;
}

glm::dvec3 ClearBeam(const Sequence& sequence, const glm::dvec3& sun_direction_enu) {
  const double elevation_rad =
      std::atan2(sun_direction_enu.z, std::hypot(sun_direction_enu.x, sun_direction_enu.y));
  return ComputeClearSky(sequence.site.value_or(Site{}), elevation_rad).beam_rgb;
}

// The sequence whose frames have the object really there, where truth has 8-bit pictures of it.
Sequence WithObject(Sequence sequence, const std::map<int, TruthFrame>& truth) {
  for (const auto& [frame, true_frame] : truth) {
    if (!true_frame.with_object_ldr) continue;
    FrameEntry& entry = sequence.frames.at(static_cast<std::size_t>(frame));
    entry.image.reset();
    entry.raw.reset();
    entry.video_frame.reset();
    entry.image_ldr = std::filesystem::relative(*true_frame.with_object_ldr, sequence.folder);
  }
  return sequence;
}

// The reference of a run's composites.
class CompositeScorer {
 public:
  CompositeScorer(const Sequence& sequence,
                  const std::map<int, TruthFrame>& truth,
                  const Mesh& phantom)
      : sequence_(sequence),
        linear_(sequence, FrameKind::kLinear),
        codes_(sequence, FrameKind::kLdr),
        with_object_(WithObject(sequence, truth), FrameKind::kLdr),
        phantom_(phantom) {
    for (const VirtualObjectEntry& entry : sequence.virtual_objects) {
      const LoadedMesh loaded = LoadMesh(sequence.folder / entry.mesh);
      objects_.push_back(TransformMesh(entry.world_from_object, loaded.mesh));
    }
  }

  // Throws std::exception with what is missing.
  void Score(const TruthFrame& truth,
             const std::function<ScoredComposite()>& composite_of_run,
             FrameScore& score) {
    if (!truth.with_object && !truth.with_object_ldr)
      throw std::runtime_error("no truth with the object");
    if (!truth.coverage) throw std::runtime_error("no truth of the object's coverage");
    const ScoredComposite composite = composite_of_run();
    const RgbImage with_object = ReadWithObject(truth);
    const Gray8Image coverage = ReadMaskImage(*truth.coverage);

    const FrameEntry& entry = sequence_.frames[static_cast<std::size_t>(truth.frame)];
    const Frame best = linear_.Read(truth.frame);
    std::optional<Frame> codes;
    score.made_from_linear = entry.image.has_value();
    if (entry.image && entry.image_ldr) {
      // The run does not say which kind it was made from; its untouched pixels do.
      Frame ldr = codes_.Read(truth.frame);
      if (CountIdenticalPixels(ldr.radiance, composite.radiance) >
          CountIdenticalPixels(best.radiance, composite.radiance)) {
        codes = std::move(ldr);
        score.made_from_linear = false;
      }
    }
    score.composite = ScoreComposite({codes ? codes->radiance : best.radiance,
                                      composite.radiance,
                                      best.radiance,
                                      with_object,
                                      coverage,
                                      composite.change ? &*composite.change : nullptr,
                                      Specular(best.camera),
                                      // Unknown: the frame's white is 1.
                                      best.exposure.value_or(1.0)});
  }

 private:
  RgbImage ReadWithObject(const TruthFrame& truth) {
    std::error_code error;
    const bool is_linear = truth.with_object && std::filesystem::exists(*truth.with_object, error);
    if (is_linear || !truth.with_object_ldr) return ReadRadianceImage(*truth.with_object);
    return with_object_.Read(truth.frame).radiance;
  }

  const Gray8Image* Specular(const Camera& camera) {
    if (!camera_ || !(*camera_ == camera)) {
      specular_ = SpecularPixels(objects_, phantom_, camera);
      camera_ = camera;
    }
    return specular_ ? &*specular_ : nullptr;
  }

  const Sequence& sequence_;
  Frames linear_;
  Frames codes_;
  Frames with_object_;
  RayCaster phantom_;
  std::vector<Mesh> objects_;
  std::optional<Camera> camera_;
  std::optional<Gray8Image> specular_;
};

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
          Summarise(frames, &CompositeScore::similarity),
          Summarise(frames, &CompositeScore::identical_outside_mask),
          Summarise(frames, &CompositeScore::changed_of_unchanged)};
}

}  // namespace

struct RunScorer::Impl {
  const Sequence& sequence;
  double largest_true_sun = 0.0;
  std::map<int, TruthFrame> truth;  // By frame.
  Mesh phantom;
  SunlitCounter sunlit;
  CompositeScorer composites;
  std::map<int, SunlitShare> sunlit_share;  // As far as requested.
  std::map<int, FrameScore> added;

  Impl(const Sequence& the_sequence, const std::vector<TruthFrame>& all)
      : sequence(the_sequence),
        largest_true_sun(LargestTrueSun(all)),
        truth(ByFrame(all)),
        phantom(LoadMesh(sequence.folder / sequence.scene_mesh).mesh),
        sunlit(sequence, phantom),
        composites(sequence, truth, phantom) {}

  FrameScore Untouched(int index) const {
    FrameScore frame;
    frame.frame = index;
    frame.time_utc = FormatUtcTime(sequence.frames[static_cast<std::size_t>(index)].time);
    return frame;
  }

  SunlitShare SunlitShareOf(const TruthFrame& true_frame) {
    const auto found = sunlit_share.find(true_frame.frame);
    if (found != sunlit_share.end()) return found->second;
    const Camera camera = sequence.CameraOfFrame(static_cast<std::size_t>(true_frame.frame));
    return sunlit_share
        .emplace(true_frame.frame, sunlit.Count(camera, true_frame.sun_direction_enu))
        .first->second;
  }

  void ScoreLights(const LightingRecord& record, const TruthFrame& true_frame, FrameScore& frame) {
    const glm::dvec3 clear_beam = ClearBeam(sequence, true_frame.sun_direction_enu);
    frame.light = ScoreLight(record.light, true_frame, largest_true_sun, clear_beam);
    if (record.raw) frame.raw = ScoreLight(*record.raw, true_frame, largest_true_sun, clear_beam);
    if (!frame.light) frame.without.push_back("light: none in its line");
    if (!frame.raw) frame.without.push_back("raw light: none in its line");
  }
};

RunScorer::RunScorer(const Sequence& sequence)
    : impl_(std::make_unique<Impl>(sequence, ReadTruth(sequence))) {}
RunScorer::~RunScorer() = default;
RunScorer::RunScorer(RunScorer&&) noexcept = default;

bool RunScorer::HasPictureOf(int frame) const {
  const auto found = impl_->truth.find(frame);
  return found != impl_->truth.end() && found->second.HasPicture();
}

void RunScorer::Add(const LightingRecord& record,
                    const std::function<ScoredComposite()>& composite) {
  const auto found = impl_->truth.find(record.frame);
  if (found == impl_->truth.end()) return;
  FrameScore frame = impl_->Untouched(record.frame);
  if (record.error) {
    frame.without.push_back("all: the run failed on it: " + *record.error);
  } else {
    impl_->ScoreLights(record, found->second, frame);
    try {
      if (composite) impl_->composites.Score(found->second, composite, frame);
    } catch (const std::exception& error) {
      frame.without.push_back(std::string("composite: ") + error.what());
    }
  }
  impl_->added[record.frame] = std::move(frame);
}

Score RunScorer::Finish() {
  Score score;
  score.sequence = impl_->sequence.name;
  score.largest_true_sun = impl_->largest_true_sun;
  for (int i = 0; i < static_cast<int>(impl_->sequence.frames.size()); ++i) {
    const auto added = impl_->added.find(i);
    FrameScore frame = added != impl_->added.end() ? std::move(added->second) : impl_->Untouched(i);
    const auto true_frame = impl_->truth.find(i);
    if (true_frame == impl_->truth.end()) {
      frame.without.push_back("all: no truth");
    } else {
      frame.sunlit = impl_->SunlitShareOf(true_frame->second);
      if (added == impl_->added.end()) {
        frame.without.push_back("light: lighting.jsonl has no line for it");
      }
    }
    score.frames.push_back(std::move(frame));
  }
  impl_->added.clear();
  score.light = Summarise(score.frames, &FrameScore::light);
  score.raw = Summarise(score.frames, &FrameScore::raw);
  score.composite = SummariseComposites(score.frames);
  return score;
}

}  // namespace pleinair
