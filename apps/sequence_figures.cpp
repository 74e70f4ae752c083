#include "apps/sequence_figures.h"

#include <cmath>

#include "apps/lighting_log.h"
#include "apps/progress.h"
#include "datasets/run_scorer.h"
#include "render/gl_context.h"
#include "session/sequence_session.h"

namespace pleinair {
namespace {

// None where the composite has changed every pixel.
std::optional<double> UntouchedShare(const Frame& frame, const Composite& composite) {
  std::size_t outside = 0;
  std::size_t untouched = 0;
  for (std::size_t i = 0; i < composite.change.pixels.size(); ++i) {
    if (composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kNone)) continue;
    ++outside;
    const glm::vec3& was = frame.radiance.pixels[i];
    const glm::vec3& is = composite.radiance.pixels[i];
    untouched += was == is || (std::isnan(was.x + was.y + was.z) && std::isnan(is.x + is.y + is.z));
  }
  if (outside == 0) return std::nullopt;
  return static_cast<double>(untouched) / static_cast<double>(outside);
}

void AddFrame(const Frame& frame, const FrameResult& result, bool pictures, RunFacts& facts) {
  ++facts.frames_done;
  if (result.estimate.samples_used > 0) {
    facts.inlier_fraction.push_back(result.estimate.inlier_fraction);
    facts.relative_residual.push_back(result.estimate.relative_residual);
  }
  if (!pictures) return;
  if (const auto share = UntouchedShare(frame, result.composite)) {
    facts.untouched_pixels.push_back(*share);
  }
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

SeededFigures MeasureFigures(const std::filesystem::path& sequence,
                             const FigureSettings& settings,
                             int seeds,
                             const std::filesystem::path& cache) {
  SessionOptions options;
  options.sequence = sequence;
  options.cache = cache;
  options.prepare.patch_size_m = settings.patch_size_m;
  options.prepare.rays = settings.rays;
  options.with_objects = settings.pictures;
  const auto loaded = LoadSequence(options, ProgressOnStandardError());
  const std::vector<bool> wanted =
      SpreadOver(static_cast<int>(loaded->sequence.frames.size()), settings.frames_limit);
  std::optional<RunScorer> scorer;
  if (std::filesystem::exists(loaded->sequence.folder / "truth" / "truth.json")) {
    scorer.emplace(loaded->sequence);
  }

  const auto context = std::make_shared<const HeadlessContext>();
  SeededFigures figures;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    SequenceSession run(loaded, options, context);
    RunFacts facts;
    while (const std::optional<SessionStep> step =
               run.Next([&](int i) { return bool{wanted[static_cast<std::size_t>(i)]}; })) {
      if (step->result) AddFrame(*step->frame, *step->result, settings.pictures, facts);
      if (!scorer) continue;
      const int index = step->result ? step->frame->index : step->result.error().index;
      const bool compare = settings.pictures && step->result && scorer->HasPictureOf(index);
      const auto composite = [&] {
        const Composite& made = step->result->composite;
        return ScoredComposite{RoundToHalf(made.radiance), made.change};
      };
      scorer->Add(RecordOf(index, step->result),
                  compare ? std::function<ScoredComposite()>(composite) : nullptr);
    }
    std::optional<Score> score;
    if (scorer) score = scorer->Finish();
    AddSeed(FiguresOf(facts, score ? &*score : nullptr), figures);
  }
  return figures;
}

}  // namespace pleinair
