// The command line: arguments in, one line and exit code 2 on bad input. The work is in
// *_command.cpp.

#include <csignal>
#include <ctime>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "apps/arguments.h"
#include "apps/calibrate_arguments.h"
#include "apps/camera_arguments.h"
#include "apps/command_line.h"
#include "apps/doctor_command.h"
#include "apps/evaluation_arguments.h"
#include "apps/help_text.h"
#include "apps/irradiance_command.h"
#include "apps/message_text.h"
#include "apps/one_of.h"
#include "apps/record_arguments.h"
#include "apps/run_arguments.h"
#include "apps/run_command.h"
#include "apps/score_command.h"
#include "apps/settings_arguments.h"
#include "apps/shared_ranks.h"
#include "apps/site_command.h"
#include "apps/sun_command.h"
#include "apps/view_arguments.h"

namespace pleinair {
namespace {

constexpr int kBadInput = 2;

// Says why in one line; returns the exit code.
int Refuse(const std::string& reason) {
  PrintError(reason);
  return kBadInput;
}

// Where to read about the command that the arguments name.
std::string SeeHelp(const CLI::App& app) {
  std::string command = app.get_name();
  for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
    at = at->get_subcommands().back();
    command += " " + at->get_name();
  }
  return " (see `" + command + " --help`)";
}

// A log message as MessageText has it.
class MessageFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message,
              const std::tm&,
              spdlog::memory_buf_t& line) override {
    const std::string text = MessageText({message.payload.data(), message.payload.size()});
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<MessageFlag>();
  }
};

void SetUpLog() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("pleinair"));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<MessageFlag>('*').set_pattern("%^%l%$ %*");
  spdlog::set_formatter(std::move(formatter));
}

void AddSun(CLI::App& app, Work& work) {
  auto options = std::make_shared<SunCommandOptions>();
  CLI::App& sun = *app.add_subcommand("sun", "Sun position for a place and time");
  sun.footer("Example: pleinair sun --site 57.0488,9.9217,15 --time 2005-06-21T09:50:00Z");
  sun.add_option(
         "--site", options->site, "LAT,LON[,H] in degrees (north, east positive) and metres")
      ->type_name("LAT,LON[,H]")
      ->required();
  sun.add_option("--time", options->time, "UTC, ISO 8601: 2005-06-21T09:50:00Z")
      ->type_name("TIME")
      ->required();
  sun.add_option("--ut1-utc", options->ut1_minus_utc_s, "UT1 - UTC in seconds (default 0)")
      ->type_name("SECONDS");
  sun.add_option(
         "--delta-t", options->tt_minus_ut1_s, "TT - UT1 in seconds (default: the library's)")
      ->type_name("SECONDS");
  sun.add_option("--pressure-hpa",
                 options->pressure_hpa,
                 "for refraction (default: standard atmosphere at the site's height)")
      ->type_name("HPA");
  sun.add_option("--temperature-c",
                 options->temperature_c,
                 "for refraction (default: the standard atmosphere's)")
      ->type_name("CELSIUS");
  sun.add_flag("--json", options->json, "print JSON");
  sun.callback([options, &work] {
    work = [options] {
      if (const auto warning = SunCommandWarning(*options)) spdlog::warn("{}", *warning);
      return Print(RunSunCommand(*options));
    };
  });
}

void AddPrepare(CLI::App& app, Work& work) {
  auto options = std::make_shared<PrepareCommandOptions>();
  auto given = std::make_shared<GivenSettings>();
  CLI::App& prepare =
      *app.add_subcommand("prepare", "The offline part of a site, kept in the cache");
  prepare.footer("Example: pleinair prepare datasets/samples/courtyard --maps maps");
  prepare.add_option("sequence", options->sequence, "folder with sequence.json")
      ->type_name("FOLDER")
      ->required();
  prepare
      .add_option(
          "--maps", options->maps, "write albedo, normal, ambient weight, ... as EXR and PNG")
      ->type_name("FOLDER");
  AddSettingOption(prepare, "--bounces", "prepare.bounces", *given, "Options");
  AddSettings(prepare, *given);
  AddCache(prepare, options->cache);
  prepare.parse_complete_callback([options, given] {
    SessionOptions session;
    given->ApplyTo(session);
    for (const std::string& assignment : given->assignments) {
      if (assignment.starts_with("prepare.")) continue;
      throw std::invalid_argument("--set " + assignment + ": expected a setting of prepare.");
    }
    options->prepare = session.prepare;
  });
  prepare.callback([options, &work] {
    work = [options] {
      RunPrepareCommand(*options);
      return 0;
    };
  });
}

void AddScore(CLI::App& app, Work& work) {
  auto options = std::make_shared<ScoreCommandOptions>();
  CLI::App& score = *app.add_subcommand("score", "Errors of a run against the truth");
  score.footer("Example: pleinair score datasets/samples/courtyard out");
  score.add_option("sequence", options->sequence, "folder with sequence.json and truth/")
      ->type_name("FOLDER")
      ->required();
  score.add_option("out", options->out, "what `pleinair run` wrote")
      ->type_name("FOLDER")
      ->required();
  score.add_flag("--json", options->json, "print JSON in place of the table");
  score.callback(
      [options, &work] { work = [options] { return Print(RunScoreCommand(*options)); }; });
}

void AddIrradiance(CLI::App& app, Work& work) {
  auto options = std::make_shared<IrradianceCommandOptions>();
  CLI::App& irradiance = *app.add_subcommand(
      "irradiance", "Irradiance at given points and normals, to check against other programs");
  irradiance.footer(
      "Example: pleinair irradiance --scene room.obj --points points.json --out out.json "
      "--sky-regions 4x16 --light indirect");
  irradiance
      .add_option("--scene", options->scene, "mesh, used unchanged; rays that miss it see sky")
      ->type_name("FILE");
  irradiance
      .add_option("--points", options->points, R"({"points": [[x,y,z],...], "normals": ...})")
      ->type_name("FILE")
      ->required();
  irradiance.add_option("--out", options->out, "JSON to write")->type_name("FILE")->required();
  irradiance
      .add_option("--sky-regions",
                  options->sky_regions,
                  "BANDSxSECTORS: unit radiance of each region (default 4x16)")
      ->type_name("BANDSxSECTORS");
  irradiance
      .add_option_function<std::string>(
          "--sky",
          [options](const std::string&) { options->uniform_sky = true; },
          "uniform: unit radiance of the entire sky")
      ->type_name("NAME")
      ->check(CLI::IsMember({"uniform"}));
  irradiance
      .add_option(
          "--sun", options->sun, "AZ,EL in degrees, azimuth from north clockwise: unit irradiance")
      ->type_name("AZ,EL");
  irradiance
      .add_option("--sequence",
                  options->sequence,
                  "in place of scene and light: a frame's own estimated light")
      ->type_name("FOLDER");
  irradiance.add_option("--frame", options->frame, "which frame of the sequence, from 0");
  irradiance
      .add_option("--light", options->light, "direct, indirect (reflected by surfaces) or total")
      ->transform(OneOf<LightPart>({{"direct", LightPart::kDirect},
                                    {"indirect", LightPart::kIndirect},
                                    {"total", LightPart::kTotal}}))
      ->type_name("PART")
      ->default_str("total");
  AddBounces(irradiance, options->gather.bounces);
  irradiance.add_flag("--sh",
                      options->spherical_harmonics,
                      "write 9 coefficients of incident radiance per point instead");
  irradiance.add_option("--patch-size",
                        options->gather.patch_size_m,
                        "longest edge of patches at a point, in metres; 0: as short as 16000 "
                        "patches allow");
  irradiance
      .add_option("--rays", options->gather.rays_per_point, "gathering rays per point and normal")
      ->check(CLI::Range(1, 65536));
  irradiance.add_option(
      "--sky-rays", options->gather.sky_rays_per_point, "rays to the sky per point");
  irradiance
      .add_option("--patch-rays", options->gather.rays_per_patch, "rays of form factors per patch")
      ->check(CLI::Range(1, 65536));
  irradiance.add_option(
      "--patch-sky-rays", options->gather.sky_rays_per_patch, "rays to the sky per patch");
  AddGroundAlbedo(irradiance, options->gather.ground_albedo);
  irradiance.add_option("--seed", options->gather.seed, "seed of all rays")->check(WholeNumber());
  AddCache(irradiance, options->cache);
  irradiance.callback([options, &work] {
    work = [options] {
      RunIrradianceCommand(*options);
      return 0;
    };
  });
}

void AddDoctor(CLI::App& app, Work& work) {
  auto json = std::make_shared<bool>(false);
  CLI::App& doctor =
      *app.add_subcommand("doctor", "GL, cameras, models, clock: what works, what is missing");
  doctor.footer("Example: pleinair doctor");
  doctor.add_flag("--json", *json, "print JSON");
  doctor.callback([json, &work] {
    work = [json] {
      bool all_well = false;
      Print(RunDoctorCommand(*json, &all_well));
      return all_well ? 0 : 1;
    };
  });
}

}  // namespace

int RunCommandLine(int argc, char** argv) {
  // A write beyond the limit on a file's size then fails and is reported, like one to a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  SetUpLog();
  const bool shared = SharedRanks() != nullptr;
  if (shared && SharedRanks()->Rank() != 0) spdlog::set_level(spdlog::level::off);

  CLI::App app(
      "Virtual objects in the picture of an ordinary camera, lit by the real light of the scene.");
  app.name("pleinair");
  app.require_subcommand(1);
  app.set_help_flag("-h,--help", "this help");
  app.set_version_flag("--version", PLEINAIR_VERSION, "the version");
  app.option_defaults()->always_capture_default();
  app.formatter(std::make_shared<HelpText>());
  Work work;
  AddSun(app, work);
  AddPrepare(app, work);
  AddRun(app, work);
  AddView(app, work);
  AddRecord(app, work);
  AddCameras(app, work);
  AddScore(app, work);
  AddRegress(app, work);
  AddTradeoff(app, work);
  AddCalibrate(app, work);
  AddSite(app, work);
  AddIrradiance(app, work);
  AddSettingsCommand(app, work);
  AddDoctor(app, work);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    return app.exit(done);  // --help, --version
  } catch (const CLI::Error& error) {
    // An unknown word is the likelier cause of what is then found missing.
    const std::vector<std::string> unknown = app.remaining(true);
    const std::string reason = unknown.empty() ? error.what() : unknown.front() + ": unknown here";
    return Refuse(reason + SeeHelp(app));
  } catch (
      const std::invalid_argument& error) {  // An argument that reads well, and makes no sense.
    return Refuse(error.what() + SeeHelp(app));
  } catch (const std::exception& error) {  // A file of settings.
    return Refuse(error.what());
  }
  if (shared && SharedRanks()->Count() > 1 && !app.got_subcommand("irradiance")) {
    return Refuse("only the command irradiance can use several ranks");
  }
  try {
    return work();
  } catch (const std::exception& error) {
    return Refuse(error.what());
  }
}

}  // namespace pleinair
