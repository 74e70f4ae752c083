#include "apps/site_new_command.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>

#include <fmt/format.h>

#include "apps/message_text.h"
#include "apps/number_table.h"
#include "datasets/new_site.h"
#include "datasets/sequence.h"
#include "datasets/stated_pose.h"
#include "sunmodel/angles.h"
#include "sunmodel/site.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

glm::dvec3 PointFrom(const std::string& text, const std::string& what) {
  const std::vector<double> numbers = ParseNumbers(text, what);
  if (numbers.size() != 3) {
    throw std::invalid_argument(what + " " + text + ": expected X,Y,Z in metres");
  }
  return {numbers[0], numbers[1], numbers[2]};
}

MeshFrame FrameFrom(const std::string& units, const std::string& up) {
  if (up != "y" && up != "z") throw std::invalid_argument("up '" + up + "': expected y or z");
  return {MetresOfUnit(units), up == "y"};
}

// Two options that only make sense together.
void RequireBoth(bool first, bool second, const char* names) {
  if (first != second) throw std::invalid_argument(std::string(names) + ": expected both");
}

// Returns lines to print.
std::string ApplyPlaceAndMesh(const SiteNewOptions& options) {
  std::string notes;
  if (!options.place.empty()) SetSitePlace(options.folder, ParseSite(options.place));
  if (!options.mesh.empty()) {
    for (const std::string& name : SetSiteMesh(
             options.folder, options.mesh, FrameFrom(options.mesh_units, options.mesh_up))) {
      notes += "note: diffuse region '" + name + "' is dropped: the new mesh does not have it\n";
    }
  }
  if (!options.diffuse_regions.empty()) {
    SetDiffuseRegions(options.folder, options.diffuse_regions);
  }
  return notes;
}

// A line to print.
std::string NoteOn(SiteLens lens) {
  switch (lens) {
    case SiteLens::kReplaced:
      return "note: its EXIF lens replaces the one from an earlier photograph; a pose that was "
             "found with that one may be off\n";
    case SiteLens::kKept:
      return "note: its EXIF lens is not used: the site has a calibrated one\n";
    case SiteLens::kAsAsked:
      break;
  }
  return {};
}

// Returns lines to print.
std::string ApplyCamera(const SiteNewOptions& options) {
  std::string notes;
  if (!options.lens.empty()) SetSiteLens(options.folder, ReadCameraIntrinsics(options.lens));
  if (!options.camera.empty()) notes = NoteOn(SetSiteCamera(options.folder, options.camera));
  if (!options.pose.empty()) SetSitePose(options.folder, ReadPoseFile(options.pose), std::nullopt);
  RequireBoth(!options.camera_at.empty(), !options.camera_to.empty(), "--camera-at, --camera-to");
  if (options.camera_at.empty()) return notes;
  const std::string& photo = options.camera.empty() ? options.earlier_camera : options.camera;
  SetSitePose(
      options.folder,
      PoseLookingAt(PointFrom(options.camera_at, "--camera-at"),
                    PointFrom(options.camera_to, "--camera-to"),
                    std::filesystem::is_regular_file(photo) ? UpInPicture(photo) : kUpright),
      std::nullopt);
  return notes;
}

void ApplyLightAndObjects(const SiteNewOptions& options) {
  const bool has_map = !options.environment.empty();
  RequireBoth(has_map, !options.environment_at.empty(), "--environment, --environment-at");
  RequireBoth(has_map, !options.environment_time.empty(), "--environment, --environment-time");
  if (has_map) {
    SetSiteEnvironment(options.folder,
                       options.environment,
                       PointFrom(options.environment_at, "--environment-at"),
                       ParseUtcTime(options.environment_time));
  }
  if (!options.albedos.empty()) SetSiteAlbedos(options.folder, options.albedos == "known");
  RequireBoth(!options.object.empty(), !options.object_at.empty(), "--object, --object-at");
  if (options.object.empty()) return;
  AddSiteObject(options.folder,
                options.object,
                FrameFrom(options.object_units, options.object_up),
                PointFrom(options.object_at, "--object-at"),
                RadFromDeg(options.object_turn_deg));
}

// Returns lines to print.
std::string Apply(const SiteNewOptions& options) {
  std::string notes = ApplyPlaceAndMesh(options) + ApplyCamera(options);
  ApplyLightAndObjects(options);
  return notes;
}

// Refuses a missing file at once, before further questions about it.
std::string Existing(const std::string& file) {
  if (std::filesystem::exists(file)) return file;
  throw std::invalid_argument(file + ": no such file");
}

// One answer: the option that it is for, and what it stands for where it is empty. `put` throws
// where the answer cannot be right.
struct Question {
  const char* text;
  std::function<void(SiteNewOptions&, const std::string&)> put;
  const char* standard = "";  // Empty: an empty answer leaves the part out.
};

std::vector<Question> QuestionsFor(SitePart part) {
  switch (part) {
    case SitePart::kPlace:
      return {{"latitude,longitude[,height] (degrees north and east, metres)",
               [](SiteNewOptions& to, const std::string& text) { to.place = text; }}};
    case SitePart::kMesh:
      return {{"mesh file",
               [](SiteNewOptions& to, const std::string& text) { to.mesh = Existing(text); }},
              {"its unit: m, cm, mm, ft or in",
               [](SiteNewOptions& to, const std::string& text) { to.mesh_units = text; },
               "m"},
              {"its up axis: z or y (a glTF is turned anyway)",
               [](SiteNewOptions& to, const std::string& text) { to.mesh_up = text; },
               "z"}};
    case SitePart::kCamera:
      return {{"camera device or identity, or a photograph of the camera",
               [](SiteNewOptions& to, const std::string& text) { to.camera = text; }}};
    case SitePart::kLens:
      return {{"file with `camera`, of pleinair calibrate lens",
               [](SiteNewOptions& to, const std::string& text) { to.lens = Existing(text); }}};
    case SitePart::kPose:
      return {{"camera's place X,Y,Z in metres (rough; pleinair calibrate pose is better)",
               [](SiteNewOptions& to, const std::string& text) { to.camera_at = text; }},
              {"a point X,Y,Z in the middle of its picture",
               [](SiteNewOptions& to, const std::string& text) { to.camera_to = text; }}};
    case SitePart::kAlbedo:
      return {
          {"lat-long environment map (EXR, HDR)",
           [](SiteNewOptions& to, const std::string& text) { to.environment = Existing(text); }},
          {"where it was taken, X,Y,Z in metres",
           [](SiteNewOptions& to, const std::string& text) { to.environment_at = text; }},
          {"when, in UTC (2026-06-21T10:00:00Z, or with an offset: 12:00:00+02:00)",
           [](SiteNewOptions& to, const std::string& text) { to.environment_time = text; }}};
    case SitePart::kObjects:
      return {{"virtual object's file",
               [](SiteNewOptions& to, const std::string& text) { to.object = Existing(text); }},
              {"where it stands, X,Y,Z in metres",
               [](SiteNewOptions& to, const std::string& text) { to.object_at = text; }},
              {"its unit: m, cm, mm, ft or in",
               [](SiteNewOptions& to, const std::string& text) { to.object_units = text; },
               "m"},
              {"its up axis: z or y (a glTF is turned anyway)",
               [](SiteNewOptions& to, const std::string& text) { to.object_up = text; },
               "z"}};
  }
  return {};
}

// Until the part is there or left for later. False: there are no more answers. `camera`: the last
// one answered.
bool AskFor(const SitePartState& state,
            const std::filesystem::path& folder,
            const Ask& ask,
            std::string& camera,
            std::string& notes) {
  std::string before = fmt::format("\nmissing{}: {}\n  how to get it: {}\n",
                                   state.is_required ? "" : " (not required)",
                                   state.name,
                                   state.how);
  while (true) {
    SiteNewOptions answers;
    answers.folder = folder;
    answers.earlier_camera = camera;
    try {
      for (const Question& question : QuestionsFor(state.part)) {
        const std::string standard = question.standard;
        const auto answer = ask(fmt::format(
            "{}  {} [{}]: ", before, question.text, standard.empty() ? "later" : standard));
        before.clear();
        if (!answer) return false;
        const bool is_left_out = answer->empty() && standard.empty();
        if (is_left_out) return true;
        question.put(answers, answer->empty() ? standard : *answer);
      }
      notes += Apply(answers);
      if (!answers.camera.empty()) camera = answers.camera;
      return true;
    } catch (const std::exception& error) {
      before = "  " + MessageText(error.what()) + "\n";
    }
  }
}

// Why the site's file would be refused; empty where it would not.
std::string RefusalOf(const std::filesystem::path& folder) {
  try {
    ReadSite(folder, std::chrono::system_clock::now());
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::string StateText(const std::filesystem::path& folder) {
  std::string text = folder.string() + "\n";
  bool is_complete = true;
  std::string next;
  for (const SitePartState& part : SitePartsIn(folder)) {
    if (part.value) {
      text += fmt::format("  {:<8} {}\n", part.name, *part.value);
      continue;
    }
    text += fmt::format("  {:<8} {}: {}\n{:11}{}\n",
                        part.name,
                        part.is_required ? "MISSING" : "none, not required",
                        part.how,
                        "",
                        part.command);
    if (!part.is_required) continue;
    is_complete = false;
    if (next.empty()) next = part.command;
  }
  if (!is_complete) return text + "next: " + next + "\n";
  const std::string refusal = RefusalOf(folder);
  if (!refusal.empty()) return text + "next: correct " + refusal + "\n";
  return text + "next: pleinair site check " + folder.string() + "\n";
}

}  // namespace

std::string RunSiteNew(const SiteNewOptions& options, const Ask& ask) {
  StartSite(options.folder);
  std::string notes = Apply(options);
  if (ask) {
    std::string camera = options.camera;
    for (const SitePart part : kSiteParts) {
      const std::vector<SitePartState> states = SitePartsIn(options.folder);
      const auto state = std::find_if(
          states.begin(), states.end(), [&](const auto& one) { return one.part == part; });
      if (!state->value && !AskFor(*state, options.folder, ask, camera, notes)) break;
    }
  }
  return notes + StateText(options.folder);
}

Ask AskOnTerminal() {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) return {};
  return [](const std::string& question) -> std::optional<std::string> {
    std::fputs(OutputText(question).c_str(), stderr);
    std::fflush(stderr);
    std::string answer;
    if (!std::getline(std::cin, answer)) return std::nullopt;
    return answer;
  };
}

}  // namespace pleinair
