#include "apps/imperfection_trials.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "apps/lighting_log.h"
#include "apps/scratch_folder.h"
#include "apps/sequence_figures.h"
#include "datasets/composite_score.h"
#include "datasets/lighting_score.h"
#include "datasets/statistics.h"
#include "datasets/truth.h"
#include "scene/image_io.h"
#include "session/session_choices.h"

namespace pleinair {
namespace {

// The part of a recording that all its runs are compared with.
struct TrialRecording {
  Sequence sequence;
  std::vector<int> frames;        // Frames that are run.
  std::vector<TruthFrame> truth;  // One a frame that is run.
  double largest_true_sun = 0.0;
};

TrialRecording ReadRecording(const std::filesystem::path& folder, int frames_limit) {
  TrialRecording recording;
  recording.sequence = ReadSequence(folder);
  if (SourceOf({}, recording.sequence) != SourceKind::kOutdoor) {
    throw std::runtime_error(folder.string() +
                             ": a fish-eye measures its light: expected a sequence whose light is "
                             "estimated from its frames");
  }
  const std::vector<TruthFrame> truth = ReadTruth(recording.sequence);
  recording.largest_true_sun = LargestTrueSun(truth);
  std::vector<TruthFrame> with_picture;
  for (const TruthFrame& frame : truth) {
    if (frame.with_object && frame.coverage) with_picture.push_back(frame);
  }
  const std::vector<TruthFrame>& usable = with_picture.empty() ? truth : with_picture;
  const std::vector<bool> taken = SpreadOver(static_cast<int>(usable.size()), frames_limit);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (!taken[i]) continue;
    recording.frames.push_back(usable[i].frame);
    recording.truth.push_back(usable[i]);
  }
  return recording;
}

// Code values that objects are off by, over runs' frames.
class ObjectError {
 public:
  void Add(const CompositeScore& score) {
    if (!score.object_psnr_db) return;
    squares_ += score.object_pixels * std::pow(10.0, -*score.object_psnr_db / 10.0);
    pixels_ += score.object_pixels;
  }
  std::optional<double> Codes() const {
    if (pixels_ == 0) return std::nullopt;
    return 255.0 * std::sqrt(squares_ / pixels_);
  }

 private:
  double squares_ = 0.0;
  int pixels_ = 0;
};

CompositeScore ScoreObject(const TruthFrame& truth,
                           const Sequence& source,
                           const Degradation& degradation,
                           const SessionStep& step) {
  const Frame& frame = *step.frame;
  const FrameEntry& entry = source.frames[static_cast<std::size_t>(truth.frame)];
  const Rgb8Image codes = degradation.Picture(
      ReadRadianceImage(*truth.with_object), entry.EffectiveExposure().value(), frame.index);
  const double exposure = frame.exposure.value_or(1.0);
  const RgbImage with_object = RadianceFromCodes(codes, ResponseCurve::Srgb(), exposure);
  return ScoreComposite({frame.radiance,
                         step.result->composite.radiance,
                         frame.radiance,
                         with_object,
                         ReadMaskImage(*truth.coverage),
                         nullptr,
                         nullptr,
                         exposure});
}

// Adds the outcome of one run to `result`.
void RunOnce(const TrialRecording& recording,
             const Imperfections& imperfections,
             std::uint64_t seed,
             const SessionOptions& options,
             ImperfectionResult& result) {
  const Degradation degradation(imperfections, seed);
  degradation.Write(recording.sequence, recording.frames, options.sequence);
  SequenceSession run(options);
  std::vector<double> ratios;
  std::vector<double> suns;
  std::vector<double> skies;
  ObjectError objects;
  while (const std::optional<SessionStep> step = run.Next()) {
    if (!step->result) {
      result.failure = step->result.error().reason;
      continue;
    }
    const TruthFrame& truth = recording.truth[static_cast<std::size_t>(step->frame->index)];
    const RecordedLight light = RecordOf(step->frame->index, step->result).light;
    if (const auto error = LogSunOverSkyError(light, truth, recording.largest_true_sun)) {
      for (int c = 0; c < 3; ++c) ratios.push_back((*error)[c]);
    }
    if (!(imperfections.exposure_ev > 0.0)) {
      const auto score = ScoreLight(light, truth, recording.largest_true_sun, glm::dvec3(1.0));
      if (score && score->sun_error) suns.push_back(*score->sun_error);
      if (score && score->sky_error) skies.push_back(*score->sky_error);
    }
    if (truth.with_object && truth.coverage) {
      objects.Add(ScoreObject(truth, recording.sequence, degradation, *step));
    }
  }
  result.runs.push_back({Median(std::move(ratios)),
                         Median(std::move(suns)),
                         Median(std::move(skies)),
                         objects.Codes()});
}

}  // namespace

std::vector<ImperfectRecording> MeasureImperfections(const ImperfectionSettings& settings,
                                                     const std::vector<ImperfectionDial>& dials,
                                                     const Progress& progress) {
  std::vector<TrialRecording> recordings;
  for (const std::filesystem::path& folder : settings.sequences) {
    recordings.push_back(ReadRecording(folder, settings.frames_limit));
  }
  const ScratchFolder scratch;
  SessionOptions options = settings.session;
  options.sequence = scratch.Path() / "sequence";
  if (options.cache.empty()) options.cache = scratch.Path() / "cache";
  options.frames = FrameKind::kLdr;

  const bool without_maps = std::any_of(
      dials.begin(), dials.end(), [](const ImperfectionDial& dial) { return dial.without_map; });
  std::size_t sizes = without_maps ? 2 : 1;
  for (const ImperfectionDial& dial : dials) sizes += dial.sizes.size();
  std::size_t done = 0;
  const auto measure = [&](const TrialRecording& recording, const Imperfections& imperfections) {
    progress("imperfections",
             static_cast<double>(done++) / static_cast<double>(sizes * recordings.size()));
    ImperfectionResult result;
    for (int seed = 1; seed <= settings.seeds; ++seed) {
      options.light.seed = static_cast<std::uint64_t>(seed);
      std::filesystem::remove_all(options.sequence);
      std::filesystem::create_directories(options.sequence);
      try {
        RunOnce(recording, imperfections, options.light.seed, options, result);
      } catch (const std::exception& error) {
        result.failure = error.what();
      }
    }
    return result;
  };

  std::vector<ImperfectRecording> measured;
  for (const TrialRecording& recording : recordings) {
    ImperfectRecording& of_recording = measured.emplace_back();
    of_recording.name = recording.sequence.NameOrFolder();
    of_recording.frames = static_cast<int>(recording.frames.size());
    of_recording.perfect = measure(recording, {});
    Imperfections without_map;
    without_map.map_withheld = true;
    if (without_maps) of_recording.without_map = measure(recording, without_map);
    for (const ImperfectionDial& dial : dials) {
      std::vector<ImperfectionResult>& of_dial = of_recording.dials.emplace_back();
      for (const double size : dial.sizes) {
        Imperfections imperfections = dial.without_map ? without_map : Imperfections{};
        dial.set(imperfections, size);
        of_dial.push_back(measure(recording, imperfections));
        of_dial.back().size = size;
      }
    }
  }
  progress("imperfections", 1.0);
  return measured;
}

}  // namespace pleinair
