#include "apps/sequence_figures.h"

#include <cmath>

#include "apps/lighting_log.h"
#include "apps/progress.h"
#include "datasets/judged_sunshine.h"
#include "datasets/truth.h"
#include "render/gl_context.h"
#include "session/sequence_session.h"
#include "session/settings.h"

namespace pleinair {
namespace {

FrameFacts FactsOf(const Frame& frame, const FrameResult& result, bool pictures) {
  const LightingEstimate& estimate = result.estimate;
  FrameFacts facts;
  facts.time = frame.time;
  facts.sun_irradiance_rgb = estimate.lighting.sun.irradiance_rgb;
  facts.sky_irradiance_rgb = estimate.lighting.SkyIrradianceRgb();
  facts.has_common_unit = estimate.units != LightUnits::kRelativePerFrame;
  facts.light_is_known = LightIsKnown(estimate.lighting);
  if (estimate.samples_used > 0) {
    facts.inlier_fraction = estimate.inlier_fraction;
    facts.relative_residual = estimate.relative_residual;
  }
  if (pictures) {
    facts.untouched_share = UntouchedShare(frame.radiance, result.composite);
    facts.glowing_pixels = CountGlowingPixels(frame.radiance, result.composite);
    facts.clamped_pixels = result.clamped_pixels;
  }
  return facts;
}

}  // namespace

std::vector<bool> SpreadOver(int count, int limit) {
  if (limit <= 0 || limit >= count) return std::vector<bool>(static_cast<std::size_t>(count), true);
  std::vector<bool> taken(static_cast<std::size_t>(count), false);
  for (int i = 0; i < limit; ++i) {
    const double place = limit == 1 ? 0.0 : double(i) * (count - 1) / (limit - 1);
    taken[static_cast<std::size_t>(std::llround(place))] = true;
  }
  return taken;
}

std::vector<bool> SpreadOverPictured(const RunScorer& scorer, int count, int limit) {
  std::vector<int> pictured;
  for (int i = 0; i < count; ++i) {
    if (scorer.HasPictureOf(i)) pictured.push_back(i);
  }
  const std::vector<bool> taken_of_pictured = SpreadOver(static_cast<int>(pictured.size()), limit);
  std::vector<bool> taken(static_cast<std::size_t>(count), false);
  for (std::size_t i = 0; i < pictured.size(); ++i) {
    if (taken_of_pictured[i]) taken[static_cast<std::size_t>(pictured[i])] = true;
  }
  return taken;
}

std::vector<RunToJudge> RunForFigures(const std::filesystem::path& sequence,
                                      const FigureSettings& settings,
                                      int seeds,
                                      const std::filesystem::path& cache) {
  SessionOptions options;
  options.sequence = sequence;
  options.cache = cache;
  for (const std::string& assignment : settings.assignments) ApplySetting(assignment, options);
  options.with_objects = settings.pictures;
  const auto loaded = LoadSequence(options, ProgressOnStandardError());
  const std::vector<bool> wanted =
      SpreadOver(static_cast<int>(loaded->sequence.frames.size()), settings.frames_limit);
  std::optional<RunScorer> scorer;
  if (HasTruth(loaded->sequence)) scorer.emplace(loaded->sequence);
  const std::vector<std::optional<bool>> judged = ReadJudgedSunshine(loaded->sequence);

  const auto context = std::make_shared<const HeadlessContext>();
  std::vector<RunToJudge> runs;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.light.seed = static_cast<std::uint64_t>(seed);
    SequenceSession run(loaded, options, context);
    RunToJudge& to_judge = runs.emplace_back();
    while (const std::optional<SessionStep> step =
               run.Next([&](int i) { return bool{wanted[static_cast<std::size_t>(i)]}; })) {
      const int index = step->result ? step->frame->index : step->result.error().index;
      if (step->result) {
        to_judge.done.push_back(FactsOf(*step->frame, *step->result, settings.pictures));
        to_judge.done.back().judged_sunshine = judged[static_cast<std::size_t>(index)];
      } else {
        ++to_judge.frames_failed;
      }
      if (!scorer) continue;
      const bool compare = settings.pictures && step->result && scorer->HasPictureOf(index);
      const auto composite = [&] {
        const Composite& made = step->result->composite;
        return ScoredComposite{RoundToHalf(made.radiance), made.change};
      };
      scorer->Add(RecordOf(index, step->result),
                  compare ? std::function<ScoredComposite()>(composite) : nullptr);
    }
    if (scorer) to_judge.score = scorer->Finish();
  }
  return runs;
}

SeededFigures MeasureFigures(const std::filesystem::path& sequence,
                             const FigureSettings& settings,
                             int seeds,
                             const std::filesystem::path& cache) {
  SeededFigures figures;
  for (const RunToJudge& run : RunForFigures(sequence, settings, seeds, cache)) {
    AddSeed(FiguresOf(run), figures);
  }
  return figures;
}

}  // namespace pleinair
