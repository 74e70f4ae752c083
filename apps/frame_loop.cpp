#include "apps/frame_loop.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <stop_token>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include "apps/calibrate_north_command.h"
#include "apps/frame_faults.h"
#include "apps/object_sightings.h"
#include "pipeline/shadow_direction.h"
#include "pipeline/sun_check.h"
#include "scene/angle_between.h"
#include "session/check/clock_check.h"
#include "session/direction_text.h"
#include "session/session_choices.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// Writes to log and report what the real shadows show about the sun.
void ReportShadows(const ShadowDirectionFinder& finder, std::vector<std::string>& notes) {
  const ShadowDirectionResult result = finder.Result();
  for (const FrameShadowDirection& frame : result.frames) {
    notes.push_back(
        fmt::format("frame {}: {}", frame.frame, DescribeShadowDirection(frame.shadow)));
  }
  const std::string all = "all frames: " + DescribeShadowDirection(result.all);
  notes.push_back(all);
  spdlog::info("{}", all);
  if (!result.all.ContradictsTheSun()) return;
  notes.push_back(fmt::format(
      "the shadows indicate a sun {:.1f} deg {} of the computed one: north, place or time may be "
      "wrong; see `pleinair calibrate north`",
      std::abs(DegFromRad(result.all.azimuth_offset_rad)),
      result.all.azimuth_offset_rad > 0.0 ? "clockwise" : "counter-clockwise"));
  spdlog::warn("{}", notes.back());
}

void NoteContradiction(const std::optional<SunContradiction>& contradiction,
                       const Sequence& sequence,
                       std::vector<std::string>& notes) {
  if (!contradiction) return;
  const auto frame = static_cast<std::size_t>(contradiction->frame);
  const std::string shown = AzimuthAndElevation(contradiction->shown_enu);
  if (contradiction->stated_enu == kNoSunDirectionEnu) {
    notes.push_back(
        fmt::format("frame {}: the shadows show a sun at {}, where none is stated: its "
                    "weather may be wrong, and sun_direction_enu or a site would help",
                    frame,
                    shown));
  } else {
    const bool stated = (frame < sequence.frames.size() ? sequence.StatedSunDirectionEnu(frame)
                                                        : sequence.StatedSunDirectionEnu())
                            .has_value();
    notes.push_back(
        fmt::format("frame {}: the shadows show the sun {:.1f} deg (sigma {:.1f}) from where it is "
                    "{}: at {}, not at {}: {} may be wrong; see `pleinair calibrate north`",
                    frame,
                    DegFromRad(contradiction->angle_rad),
                    DegFromRad(contradiction->stddev_rad),
                    stated ? "stated" : "computed",
                    shown,
                    AzimuthAndElevation(contradiction->stated_enu),
                    stated ? "sun_direction_enu, or the camera's pose or lens,"
                           : "the model's north, place or time (zone), or the camera's pose or "
                             "lens,"));
  }
  spdlog::warn("{}", notes.back());
}

std::string DescribeSunElsewhere(int frame, const LightingEstimate& estimate) {
  const glm::dvec3& stated_enu = estimate.lighting.sun.direction_enu;
  const glm::dvec3& shown_enu = estimate.sun_elsewhere_enu.value();
  return fmt::format(
      "frame {}: the fish-eye picture shows the sun {:.1f} deg from where it is stated or "
      "computed: at {}, not at {}: fisheye.up, image_up, image_right or fov_deg, or the sun's "
      "direction, place or time may be wrong; the sun's strength is used, its place is not",
      frame,
      DegFromRad(AngleBetweenRad(shown_enu, stated_enu)),
      AzimuthAndElevation(shown_enu),
      AzimuthAndElevation(stated_enu));
}

// Once a run: what the light's numbers stand for.
void NoteUnits(LightUnits units, std::vector<std::string>& notes) {
  static const std::string kAll =
      "the exposure of 8-bit frames is known up to one factor: light is relative, not in the "
      "survey's units";
  static const std::string kEach =
      "the exposure of 8-bit frames is not known (a frame's exposure, or exposure_s, iso and "
      "f_number, would give it): light is relative, each frame's in the units of its own picture";
  if (units == LightUnits::kAbsolute) return;
  const std::string& note = units == LightUnits::kRelative ? kAll : kEach;
  if (std::find(notes.begin(), notes.end(), note) != notes.end()) return;
  notes.push_back(note);
  spdlog::warn("{}", note);
}

// Runs `work` on this thread alone, without the others of the pool, and at the lowest priority.
template <typename Work>
auto InTheBackground(const Work& work) {
  constexpr int kLowestPriority = 19;
  setpriority(PRIO_PROCESS, 0, kLowestPriority);  // On Linux this sets the calling thread's.
  return tbb::task_arena(1).execute(work);
}

}  // namespace

struct FrameLoop::Checks {
  explicit Checks(bool is_measured_in_pictures) : faults(is_measured_in_pictures) {}

  std::optional<ShadowDirectionFinder> shadows;
  std::optional<SunCheck> sun;
  FrameFaults faults;
  ObjectSightings objects;
  bool is_any_done = false;
  bool is_sun_elsewhere_noted = false;
  // A look at a live frame, in the background; of one that is stopped nothing remains.
  struct LookedAt {
    Frame frame;
    Lighting lighting;
  };
  std::shared_ptr<const LookedAt> looked_at;
  std::stop_source stop_look;
  std::future<std::optional<SunLook>> sun_look;

  ~Checks() { stop_look.request_stop(); }  // Before the future waits.
};

FrameLoop::FrameLoop(const RunCommandOptions& options, SequenceSession& run, bool is_live)
    : options_(options), run_(run), is_live_(is_live) {
  const LoadedSequence& loaded = run.Loaded();
  const SiteModel& model = loaded.site.model;
  // A fish-eye camera sees the sun itself, and --lighting states the light.
  const bool is_measured_in_pictures =
      options.lighting.empty() && SourceOf(options, loaded.sequence) == SourceKind::kOutdoor;
  checks_ = std::make_unique<Checks>(is_measured_in_pictures);
  if (options.measure_shadows) checks_->shadows.emplace(model.mesh, model.diffuse_regions);
  // The shadows of a mesh in another unit, or beside the camera, are nowhere in the picture.
  const bool is_sun_checked = is_measured_in_pictures && !loaded.site.IsMisread();
  if (is_sun_checked) checks_->sun.emplace(model.mesh, model.diffuse_regions);
  TakeNotes();
  if (is_measured_in_pictures && !is_sun_checked) {
    Warn(
        "the sun's direction is not compared with the shadows, as the mesh or the pose seems to be "
        "misread");
  }
  if (const std::string note = run.DaylightNote(); !note.empty()) {
    notes_.push_back(note);
    spdlog::info("{}", note);
  }
  if (is_live_) return;
  for (const SiteWarning& warning : CheckFrameTimes(loaded.sequence)) {
    Warn(InOneLine(warning));
  }
}

FrameLoop::~FrameLoop() = default;

std::optional<FinishedFrame> FrameLoop::Next() {
  std::optional<SessionStep> step = run_.Next();
  if (!step) return std::nullopt;
  TakeNotes();
  FinishedFrame finished;
  finished.step = std::move(*step);
  if (!finished.step.result) {
    const FrameError& error = finished.step.result.error();
    spdlog::error("frame {}: {}", error.index, error.reason);
    return finished;
  }
  const Frame& frame = *finished.step.frame;
  const FrameResult& result = *finished.step.result;
  finished.shown = run_.Show(finished.step);
  if (!frame.codes) finished.input = run_.Display().Show(frame.radiance, frame.exposure);
  const Lighting& lighting = result.estimate.lighting;
  if (options_.write_environment) {
    finished.environment = run_.EnvironmentOf(result.DrawnLighting());
  }
  finished.sky = run_.SkyImageOf(lighting);
  NoteUnits(result.estimate.units, notes_);
  if (result.estimate.sun_elsewhere_enu && !checks_->is_sun_elsewhere_noted) {
    Warn(DescribeSunElsewhere(frame.index, result.estimate));
    checks_->is_sun_elsewhere_noted = true;
  }
  checks_->faults.Add(frame, result);
  checks_->objects.Add(frame.camera, result.composite);
  if (checks_->shadows) checks_->shadows->Add(frame, result.sun.direction_enu);
  if (checks_->sun) CheckSun(finished);
  checks_->is_any_done = true;
  return finished;
}

std::vector<std::string> FrameLoop::Finish() {
  if (checks_->sun_look.valid()) {
    // At the lowest priority it would take as long as a busy machine stays busy: it is stopped, and
    // done again at this thread's.
    checks_->stop_look.request_stop();
    std::optional<SunLook> look = checks_->sun_look.get();
    const Checks::LookedAt& at = *checks_->looked_at;
    if (!look) look = checks_->sun->Look(at.frame, at.lighting, {});
    NoteContradiction(look->contradiction, run_.Loaded().sequence, notes_);
  }
  for (std::string& note : checks_->faults.Notes()) Warn(std::move(note));
  if (std::optional<std::string> note = checks_->objects.Note(run_.Loaded().site.objects)) {
    Warn(std::move(*note));
  }
  if (checks_->shadows && checks_->is_any_done) ReportShadows(*checks_->shadows, notes_);
  return std::exchange(notes_, {});
}

void FrameLoop::CheckSun(const FinishedFrame& finished) {
  const Sequence& sequence = run_.Loaded().sequence;
  std::future<std::optional<SunLook>>& look = checks_->sun_look;
  if (look.valid()) {
    if (look.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    NoteContradiction(look.get()->contradiction, sequence, notes_);
  }
  const Frame& frame = *finished.step.frame;
  const Lighting& lighting = finished.step.result->estimate.lighting;
  SunCheck& sun = *checks_->sun;
  if (!sun.IsDue(lighting)) return;
  if (!is_live_) {
    NoteContradiction(sun.Look(frame, lighting), sequence, notes_);
    return;
  }
  checks_->looked_at = std::make_shared<const Checks::LookedAt>(Checks::LookedAt{frame, lighting});
  look = std::async(
      std::launch::async, [&sun, at = checks_->looked_at, stop = checks_->stop_look.get_token()] {
        return InTheBackground([&] { return sun.Look(at->frame, at->lighting, stop); });
      });
}

void FrameLoop::TakeNotes() {
  for (std::string& note : run_.TakeNotes()) Warn(std::move(note));
}

void FrameLoop::Warn(std::string note) {
  spdlog::warn("{}", note);
  notes_.push_back(std::move(note));
}

}  // namespace pleinair
