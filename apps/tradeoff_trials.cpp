#include "apps/tradeoff_trials.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "apps/lighting_log.h"
#include "apps/sequence_figures.h"
#include "datasets/statistics.h"
#include "pipeline/light_trials.h"
#include "session/session_choices.h"

namespace pleinair {
namespace {

const LightSummary& JudgedFrames(const LightSummaries& light) {
  return light.well_posed.frames > 0 ? light.well_posed : light.all;
}

std::optional<double> MedianOf(const std::optional<Distribution>& distribution) {
  return distribution ? std::optional(distribution->median) : std::nullopt;
}

double CodesOfPsnr(double psnr_db) { return 255.0 * std::pow(10.0, -psnr_db / 20.0); }

}  // namespace

SessionOptions TrialRunOptions(const TrialSettings& settings) {
  SessionOptions options = settings.session;
  options.pipeline.filter.reset();  // Each frame by itself.
  return options;
}

std::string OtherSettingsInWords(const TrialSettings& settings) {
  if (settings.assignments.empty()) return "all other settings at their defaults";
  return fmt::format("{}, other settings at their defaults", fmt::join(settings.assignments, ", "));
}

// Mean of sun's and sky's error, median over the frames that are judged.
std::optional<double> LightError(const Score& score) {
  std::vector<double> errors;
  const bool well_posed_alone = score.light.well_posed.frames > 0;
  for (const FrameScore& frame : score.frames) {
    if (!frame.light || !frame.light->sun_error || !frame.light->sky_error) continue;
    if (well_posed_alone && !frame.IsWellPosed()) continue;
    errors.push_back(0.5 * (*frame.light->sun_error + *frame.light->sky_error));
  }
  return Median(errors);
}

std::optional<double> PictureError(const Score& score) {
  std::vector<double> errors;
  for (const FrameScore& frame : score.frames) {
    if (!frame.composite || !frame.composite->object_psnr_db) continue;
    const double object = CodesOfPsnr(*frame.composite->object_psnr_db);
    const std::optional<double>& effect = frame.composite->effect_psnr_db;
    errors.push_back(effect ? 0.5 * (object + CodesOfPsnr(*effect)) : object);
  }
  return Median(errors);
}

// A value of an axis and the seeds that it is measured with at once.
struct TradeoffTrials::Job {
  const SweepAxis* axis = nullptr;
  SweepResult* result = nullptr;
  SessionOptions options;
  std::vector<std::uint64_t> seeds;
  bool done = false;

  bool SeesAsMuchAs(const Job& other) const {
    return options.prepare == other.options.prepare &&
           options.light.sky_shapes == other.options.light.sky_shapes;
  }
};

TradeoffTrials::TradeoffTrials(const TrialSettings& settings, const Progress& progress)
    : settings_(settings),
      progress_(progress),
      default_(LoadSequence(TrialRunOptions(settings), progress)),
      scorer_(default_->sequence) {
  const int count = static_cast<int>(default_->sequence.frames.size());
  const std::vector<bool> wanted = SpreadOver(count, settings_.frames_limit);
  const auto source = MakeRecordedFrameSource(default_->sequence, FrameKind::kLinear);
  for (int i = 0; auto frame = source->Next(); ++i) {
    if (!wanted[static_cast<std::size_t>(i)]) continue;
    if (*frame) {
      frames_.push_back(std::move(**frame));
    } else {
      spdlog::warn("frame {}: {}", frame->error().index, frame->error().reason);
    }
  }
  wanted_pictures_ = SpreadOverPictured(scorer_, count, settings_.frames_limit);
}

TradeoffTrials::~TradeoffTrials() = default;

SweepCase TradeoffTrials::Case() const {
  const SessionOptions options = TrialRunOptions(settings_);
  SweepCase sweep_case;
  sweep_case.light_is_fitted = SourceOf(options, default_->sequence) == SourceKind::kOutdoor;
  sweep_case.has_pictures = PictureFrames() > 0 && !default_->site.objects.empty();
  sweep_case.is_indoors = default_->site.is_indoors;
  if (const auto& map = default_->site.model.environment)
    sweep_case.map_width = map->radiance.width;
  const FramePipelineOptions pipeline = PipelineOptionsFor(options, *default_);
  sweep_case.influence_at = pipeline.influence_at;
  sweep_case.receivers_at = pipeline.view.receivers_at;
  return sweep_case;
}

int TradeoffTrials::LightFrames() const { return static_cast<int>(frames_.size()); }

int TradeoffTrials::PictureFrames() const {
  return static_cast<int>(std::count(wanted_pictures_.begin(), wanted_pictures_.end(), true));
}

std::vector<SweptAxis> TradeoffTrials::Measure(const std::vector<SweepAxis>& axes) {
  std::vector<SweptAxis> swept;
  for (const SweepAxis& axis : axes) {
    SweptAxis& of_axis = swept.emplace_back();
    of_axis.axis = axis;
    for (const SweepValue& value : axis.values) {
      of_axis.results.push_back({value.text, value.text == axis.default_text, {}, "", {}});
    }
  }
  std::vector<Job> jobs;
  for (SweptAxis& of_axis : swept) {
    const SweepAxis& axis = of_axis.axis;
    const bool is_costly = axis.rays_by_seed || !axis.JudgesLight();
    const int seeds = is_costly ? settings_.costly_seeds : settings_.seeds;
    const auto add = [&](std::size_t v, const std::vector<std::uint64_t>& with) {
      Job job{&axis, &of_axis.results[v], TrialRunOptions(settings_), with, false};
      axis.values[v].ApplyTo(job.options);
      if (axis.rays_by_seed) job.options.prepare.seed = with.front();
      jobs.push_back(std::move(job));
    };
    std::vector<std::uint64_t> all;
    for (int seed = 1; seed <= seeds; ++seed) all.push_back(static_cast<std::uint64_t>(seed));
    if (!is_costly) {
      for (std::size_t v = 0; v < axis.values.size(); ++v) add(v, all);
      continue;
    }
    // Seed by seed, so that other load on the machine affects all values equally.
    for (const std::uint64_t seed : all) {
      for (std::size_t v = 0; v < axis.values.size(); ++v) add(v, {seed});
    }
  }

  std::size_t done = 0;
  for (Job& job : jobs) {
    if (job.done) continue;
    progress_("settings", static_cast<double>(done) / static_cast<double>(jobs.size()));
    std::vector<Job*> batch;
    for (Job& other : jobs) {
      const bool goes_along = job.axis->JudgesLight() && other.axis->JudgesLight() && !other.done &&
                              job.SeesAsMuchAs(other);
      if (&other == &job || goes_along) batch.push_back(&other);
    }
    try {
      if (job.axis->JudgesLight()) {
        MeasureLight(batch);
      } else {
        MeasurePicture(job);
      }
    } catch (const std::exception& error) {
      for (Job* failed : batch) failed->result->failure = error.what();
    }
    for (Job* measured : batch) measured->done = true;
    done += batch.size();
  }
  progress_("settings", 1.0);
  return swept;
}

std::shared_ptr<const LoadedSequence> TradeoffTrials::Load(const SessionOptions& options,
                                                           double& prepare_s) {
  prepare_s = 0.0;
  if (options.prepare == settings_.session.prepare) return default_;
  if (other_ == nullptr || !(options.prepare == other_settings_)) {
    other_.reset();  // Before the next one takes as much.
    const auto start = std::chrono::steady_clock::now();
    other_ = LoadSequence(options, [](auto, auto) {});
    other_settings_ = options.prepare;
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    if (!other_->scene.from_store) prepare_s = spent.count();
  }
  return other_;
}

void TradeoffTrials::MeasureLight(const std::vector<Job*>& batch) {
  struct Trial {
    Job* job;
    std::vector<LightingRecord> records;
    std::vector<double> draw_ms;
    std::vector<double> estimate_ms;
    std::string failure;
  };
  double prepare_s = 0.0;
  const auto loaded = Load(batch.front()->options, prepare_s);
  std::vector<Trial> trials;
  std::vector<std::unique_ptr<LightingSource>> sources;
  for (Job* job : batch) {
    if (prepare_s > 0.0) job->result->prepare_s = prepare_s;
    for (const std::uint64_t seed : job->seeds) {
      SessionOptions options = job->options;
      options.light.seed = seed;
      sources.push_back(
          MakeSourceFor(options, loaded->sequence, loaded->scene.aerosol_optical_depth_500nm));
      trials.push_back({job, {}, {}, {}, ""});
    }
  }

  LightTrials views(loaded->scene,
                    loaded->sequence.site,
                    PipelineOptionsFor(batch.front()->options, *loaded).view);
  std::vector<double> view_ms;
  for (const Frame& frame : frames_) {
    const auto found = views.Process(frame, sources);
    if (!found) {
      for (Trial& trial : trials) trial.failure = found.error().reason;
      continue;
    }
    view_ms.push_back(views.ViewMs());
    for (std::size_t i = 0; i < trials.size(); ++i) {
      if (!(*found)[i]) {
        trials[i].failure = (*found)[i].error().reason;
        continue;
      }
      FrameResult result;
      result.estimate = (*found)[i]->estimate;
      result.raw_lighting = result.estimate.lighting;
      trials[i].records.push_back(RecordOf(frame.index, result));
      trials[i].draw_ms.push_back(result.estimate.new_sample_set_ms);
      trials[i].estimate_ms.push_back((*found)[i]->estimate_ms);
    }
  }

  for (Trial& trial : trials) {
    for (const LightingRecord& record : trial.records) scorer_.Add(record, nullptr);
    const Score score = scorer_.Finish();
    const std::optional<double> error = LightError(score);
    if (!trial.failure.empty()) trial.job->result->failure = trial.failure;
    if (!error) continue;
    TrialFigures figures;
    figures.error = *error;
    figures.sun_error = MedianOf(JudgedFrames(score.light).sun_error);
    figures.sky_error = MedianOf(JudgedFrames(score.light).sky_error);
    figures.transport_ms = Median(view_ms);
    figures.draw_ms = Median(trial.draw_ms);
    figures.estimate_ms = Median(trial.estimate_ms);
    figures.time_ms = *figures.estimate_ms;
    if (trial.job->axis->judge == SweepAxis::Judge::kTransport) {
      figures.time_ms += *figures.transport_ms + *figures.draw_ms;
    }
    trial.job->result->trials.push_back(figures);
  }
}

void TradeoffTrials::MeasurePicture(Job& job) {
  double prepare_s = 0.0;
  const auto loaded = Load(job.options, prepare_s);
  if (prepare_s > 0.0) job.result->prepare_s = prepare_s;
  for (const std::uint64_t seed : job.seeds) {
    SessionOptions options = job.options;
    SetSeed(seed, options);
    SequenceSession run(loaded, options, context_);
    std::vector<double> transport_ms;
    std::vector<double> estimate_ms;
    std::vector<double> objects_ms;
    std::vector<double> render_ms;
    std::vector<double> total_ms;
    while (const std::optional<SessionStep> step = run.Next(
               [&](int i) { return bool{wanted_pictures_[static_cast<std::size_t>(i)]}; })) {
      if (!step->result) {
        job.result->failure = step->result.error().reason;
        continue;
      }
      const FrameResult& result = *step->result;
      const StageTimes& ms = result.timing_ms;
      transport_ms.push_back(ms.transport);
      estimate_ms.push_back(ms.estimate);
      objects_ms.push_back(ms.relight + ms.probes);
      render_ms.push_back(ms.render + ms.readback);
      total_ms.push_back(ms.transport + ms.estimate + objects_ms.back() + render_ms.back());
      scorer_.Add(RecordOf(step->frame->index, step->result), [&result] {
        return ScoredComposite{RoundToHalf(result.composite.radiance), result.composite.change};
      });
    }
    const Score score = scorer_.Finish();
    const std::optional<double> error = PictureError(score);
    if (!error) continue;
    TrialFigures figures;
    figures.error = *error;
    figures.time_ms = *Median(total_ms);
    figures.sun_error = MedianOf(JudgedFrames(score.light).sun_error);
    figures.sky_error = MedianOf(JudgedFrames(score.light).sky_error);
    figures.object_psnr_db = MedianOf(score.composite.object_psnr_db);
    figures.effect_psnr_db = MedianOf(score.composite.effect_psnr_db);
    figures.transport_ms = Median(transport_ms);
    figures.estimate_ms = Median(estimate_ms);
    figures.objects_ms = Median(objects_ms);
    figures.render_ms = Median(render_ms);
    job.result->trials.push_back(figures);
  }
}

}  // namespace pleinair
