// The program as its user meets it: arguments in, exit code and words out.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/shell.h"
#include "tests/session/command_folder.h"

namespace pleinair::command_line_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Ended Call(const std::string& arguments) {
  return Shell(std::string(PLEINAIR_PROGRAM) + " " + arguments);
}

class CommandLine : public CommandFolder {
 protected:
  void ExpectOneLineAndCode2(const std::string& arguments, const std::string& word) {
    const Ended ended = Call(arguments);
    EXPECT_EQ(ended.exit_code, 2) << arguments << "\n" << ended.output;
    EXPECT_EQ(std::count(ended.output.begin(), ended.output.end(), '\n'), 1) << ended.output;
    EXPECT_THAT(ended.output, AllOf(testing::StartsWith("pleinair: "), HasSubstr(word)));
  }
};

TEST_F(CommandLine, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"sun",
                              "prepare",
                              "run",
                              "record",
                              "score",
                              "regress",
                              "tradeoff",
                              "doctor",
                              "cameras",
                              "irradiance",
                              "settings",
                              "view",
                              "site",
                              "site new",
                              "site import",
                              "site check",
                              "site mask",
                              "site place",
                              "calibrate",
                              "calibrate markers",
                              "calibrate pose",
                              "calibrate north",
                              "calibrate lens",
                              "calibrate fisheye",
                              "calibrate response",
                              "calibrate merge",
                              "calibrate average",
                              "calibrate colour",
                              "calibrate orientation"}) {
    const Ended ended = Call(std::string(command) + " --help");
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_THAT(ended.output, HasSubstr(std::string("Example: pleinair ") + command));
    for (const char* parsers :
         {"INT", "FLOAT", "TEXT", "POSITIVE", "WHOLE", "=[]", "{auto}", "Needs:", " in ["}) {
      EXPECT_THAT(ended.output, Not(HasSubstr(parsers))) << command;
    }
  }
}

TEST_F(CommandLine, RunShowsAFewOptionsAndAllWhereAsked) {
  const auto count = [](const std::string& help) {
    int options = 0;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
      options += line.starts_with("  -") ? 1 : 0;
    }
    return options;
  };
  const Ended few = Call("run --help");
  EXPECT_EQ(few.exit_code, 0);
  EXPECT_LE(count(few.output), 20) << few.output;
  EXPECT_THAT(
      few.output,
      AllOf(HasSubstr("--help-all"), HasSubstr("Further options, by --help-all: Camera, ")));
  const Ended all = Call("run --help-all");
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_GT(count(all.output), count(few.output));
  EXPECT_THAT(all.output,
              AllOf(HasSubstr("--white-balance"),
                    HasSubstr("--video[=RATE]"),
                    HasSubstr("Example: pleinair run")));
}

TEST_F(CommandLine, HelpSaysWhatAnOptionAcceptsAndItsDefault) {
  EXPECT_THAT(Call("tradeoff --help").output, HasSubstr("(1 to 1000; default: 20)"));
  EXPECT_THAT(Call("calibrate lens --help").output,
              HasSubstr("(0.05 to 0.95; default: 0.75; only with --charuco)"));
  EXPECT_THAT(Call("irradiance --help").output, HasSubstr("(all or 0 to 100; default: all)"));
}

TEST_F(CommandLine, RefusesUnknownWords) {
  ExpectOneLineAndCode2("", "subcommand");
  ExpectOneLineAndCode2("run folder --set sky_regions=4by16", "found '4by16'");
  ExpectOneLineAndCode2("run folder --set sky_regions=0x16", "found '0x16'");
  ExpectOneLineAndCode2("run folder --set light.sample=3", "such as light.samples");
  ExpectOneLineAndCode2("run folder --settings nowhere", "nowhere: expected a file of settings");
  ExpectOneLineAndCode2("calibrate fisheye nowhere.jpg --board 8x6 --out lens.json",
                        "pleinair: nowhere.jpg: no such file: expected pictures of a board");
  ExpectOneLineAndCode2("run folder --video=0", "--video: expected frames a second from 0.1");
  ExpectOneLineAndCode2("run folder --video=fast", "found 'fast'");
  ExpectOneLineAndCode2("run folder --weather sunny", "overcast");
  ExpectOneLineAndCode2("site check folder --frames 0", "--frames: expected linear or ldr");
  ExpectOneLineAndCode2("paint", "paint: unknown here (see `pleinair --help`)");
  ExpectOneLineAndCode2("site check", "site is required (see `pleinair site check --help`)");
  ExpectOneLineAndCode2("sun --site 57,9 --time 2005-06-21T09:50:00Z --colour red", "colour");
}

// With FFmpeg come a hundred libraries: it waits for the first video.
TEST_F(CommandLine, StartsWithoutFfmpeg) {
  const Ended ended = Shell(std::string("LD_TRACE_LOADED_OBJECTS=1 ") + PLEINAIR_PROGRAM);
  EXPECT_THAT(ended.output, HasSubstr("libopencv_core"));
  EXPECT_THAT(ended.output, Not(HasSubstr("libavcodec")));
}

TEST_F(CommandLine, RefusesABadPlaceOrTime) {
  ExpectOneLineAndCode2("sun --site 91,9 --time 2005-06-21T09:50:00Z", "latitude");
  ExpectOneLineAndCode2("sun --site here --time 2005-06-21T09:50:00Z", "here");
  ExpectOneLineAndCode2("sun --site 57,9 --time yesterday", "yesterday");
}

TEST_F(CommandLine, RefusesSettingsOutOfRange) {
  const std::string run =
      "run " PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard --out " + (folder_ / "out").string();
  ExpectOneLineAndCode2(run + " --samples 0", "samples");
  ExpectOneLineAndCode2(run + " --bounces some", "bounces");
  ExpectOneLineAndCode2(run + " --frames both", "frames");
  ExpectOneLineAndCode2(run + " --seed -1", "light.seed: expected 0 or more");
  ExpectOneLineAndCode2(run + " --effects sparkle", "effects");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "refused before anything is written";
}

// An option wins over what the quality asks for, whichever stands first.
TEST_F(CommandLine, AnOptionWinsOverTheQuality) {
  const auto samples_used = [&](const std::string& arguments) {
    const Ended ended = Call(
        "run " PLEINAIR_SOURCE_DIR
        "/datasets/samples/courtyard --bounces 0 "
        "--set prepare.patch_size_m=8 --effects sun-shading --frames-limit 1 --cache " +
        (folder_ / "cache").string() + " --out " + (folder_ / "out").string() + " " + arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    std::ifstream lighting(folder_ / "out" / "lighting.jsonl");
    std::string line;
    std::getline(lighting, line);
    const std::string key = "\"samples_used\":";
    const std::size_t at = line.find(key);
    return at == std::string::npos ? -1 : std::stoi(line.substr(at + key.size()));
  };
  const int fast = samples_used("--quality fast --set prepare.rays=16");
  EXPECT_GT(fast, 100);
  EXPECT_LT(fast, 300) << "balanced has 500";
  EXPECT_NEAR(samples_used("--samples 77 --set prepare.rays=16 --quality fast"), 77, 20);
  ExpectOneLineAndCode2("run " PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard --quality quick",
                        "--quality");
}

TEST_F(CommandLine, NamesTheMissingFile) {
  ExpectOneLineAndCode2("run " + folder_.string() + " --out " + (folder_ / "out").string(),
                        "sequence.json");
  ExpectOneLineAndCode2("score " + folder_.string() + " " + folder_.string(), "sequence.json");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

// A frame's path may hold what a terminal would obey, or another line.
TEST_F(CommandLine, EscapesWhatATerminalWouldObey) {
  const std::filesystem::path name = folder_ / "a\x1b[31m\nb";
  ExpectOneLineAndCode2("run '" + name.string() + "' --out " + (folder_ / "out").string(),
                        "a\\x1b[31m\\x0ab");
}

// 1 is for figures that got worse, 2 for bad input.
TEST_F(CommandLine, RegressEndsWith1WhereAFigureGotWorse) {
  std::ofstream(folder_ / "baseline.json")
      << R"({"format": "pleinair-baseline-2", "sequences": {"courtyard": {"settings":
             {"frames_limit": 1, "pictures": false,
             "set": ["prepare.patch_size_m=4", "prepare.rays=16"]},
             "figures": {"frames_done": [2]}}}})";
  const std::string regress =
      "regress " PLEINAIR_SOURCE_DIR "/datasets/samples --cache " + (folder_ / "cache").string();
  const Ended ended = Call(regress + " --baseline " + (folder_ / "baseline.json").string());
  EXPECT_EQ(ended.exit_code, 1) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("pleinair: courtyard: frames done: 1, in the baseline 2"));
  ExpectOneLineAndCode2(regress + " --frames-limit 3", "--write-baseline");
  ExpectOneLineAndCode2("regress " + folder_.string(), "sequence.json");
}

TEST_F(CommandLine, KeepsAnEarlierResultWhenTheNewInputIsBad) {
  const std::filesystem::path out = folder_ / "out";
  std::filesystem::create_directories(out);
  std::ofstream(out / "lighting.jsonl") << "{}\n";
  ExpectOneLineAndCode2("run " + folder_.string() + " --out " + out.string(), "sequence.json");
  EXPECT_TRUE(std::filesystem::exists(out / "lighting.jsonl"));
}

TEST_F(CommandLine, SaysWhichFileALimitOnFilesSizesStops) {
  const std::string composite = (folder_ / "out/composite/000000.exr").string();
  const Ended ended = Shell("ulimit -f 300 && " + std::string(PLEINAIR_PROGRAM) + " run " +
                            PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard --cache " +
                            (folder_ / "cache").string() +
                            " --set prepare.patch_size_m=4 --set prepare.rays=16"
                            " --frames-limit 1 --out " +
                            (folder_ / "out").string());
  EXPECT_EQ(ended.exit_code, 2) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("pleinair: " + composite)) << ended.output;
}

TEST_F(CommandLine, RefusesWrongOptionsOfARunOfACamera) {
  const std::string out = " --out " + (folder_ / "out").string();
  const std::string site = " --site " PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard" + out;
  const std::string camera = "run /dev/video200";
  ExpectOneLineAndCode2(camera + out, "/dev/video200: expected --site");
  ExpectOneLineAndCode2(camera + site, "/dev/video200: ");
  ExpectOneLineAndCode2(camera + " --site " + folder_.string() + out, folder_.string());
  ExpectOneLineAndCode2(camera + site + " --source fisheye", "--source fisheye");
  ExpectOneLineAndCode2(camera + site + " --pictures some", "all, shown or none, found 'some'");
  for (const char* duration : {"0", "-1", "nan", "soon"}) {
    ExpectOneLineAndCode2(camera + site + " --duration " + duration, "--duration");
  }
  ExpectOneLineAndCode2(camera + site + " --frames-limit 0", "--frames-limit");
  ExpectOneLineAndCode2(camera + site + " --format RGB", "--format 'RGB'");
  ExpectOneLineAndCode2(camera + site + " --size 640", "--size");
  ExpectOneLineAndCode2(camera + site + " --size 0x480", "size: expected 1 or more");
  ExpectOneLineAndCode2(camera + site + " --rate 0", "--rate");
  for (const char* exposure : {"0", "-0.1", "1/0", "1/", "fast", "nan"}) {
    ExpectOneLineAndCode2(camera + site + " --exposure " + exposure, "exposure");
  }
  ExpectOneLineAndCode2(camera + site + " --gain -1", "--gain");
  ExpectOneLineAndCode2(camera + site + " --auto --exposure 0.01", "found both");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "nothing was begun";
}

TEST_F(CommandLine, RefusesOptionsThatItsInputHasNoUseFor) {
  const std::string out = " --out " + (folder_ / "out").string() + " ";
  const std::string courtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  const std::string at_courtyard = " --site " + courtyard + out;
  const auto option_of = [](const std::string& text) { return text.substr(0, text.find(' ')); };
  for (const char* option : {"--format YUYV",
                             "--size 640x480",
                             "--rate 30",
                             "--exposure 1/100",
                             "--gain 2",
                             "--white-balance 5000",
                             "--auto",
                             "--duration 3",
                             "--record folder"}) {
    const std::string reason = option_of(option) + ": expected a camera, found recorded frames";
    for (const char* command : {"run ", "view "}) {
      const bool is_of_run = option_of(option) == "--duration" || option_of(option) == "--record";
      if (is_of_run && std::string(command) == "view ") continue;
      ExpectOneLineAndCode2(command + courtyard + out + option, reason);
      // A folder of pictures.
      ExpectOneLineAndCode2(command + courtyard + "/frames" + at_courtyard + option, reason);
    }
  }
  for (const char* command : {"run ", "view "}) {
    for (const char* option :
         {"--start-time 2026-06-21T10:00:00Z", "--every 10s", "--time-zone Z"}) {
      const std::string reason = option_of(option) + ": expected a video or pictures";
      ExpectOneLineAndCode2(command + courtyard + out + option, reason);
      ExpectOneLineAndCode2(command + std::string("/dev/video200") + at_courtyard + option, reason);
    }
    // A video states when each of its pictures is shown; whether it is one is seen later.
    const std::string video = command + Write("film.mp4", "").string() + at_courtyard;
    for (const char* option : {"--every 10s", "--time-zone Z"}) {
      ExpectOneLineAndCode2(video + option,
                            option_of(option) + ": expected pictures, found a video");
    }
    ExpectOneLineAndCode2(
        command + std::string("/dev/video200") + at_courtyard + "--source fisheye",
        "--source fisheye: expected a recorded sequence, found a camera");
    ExpectOneLineAndCode2(command + courtyard + out + "--markers a.json --poses b.jsonl",
                          "--markers and --poses exclude each other");
    ExpectOneLineAndCode2(command + courtyard + out + "--lighting a.jsonl --source outdoor",
                          "--lighting and --source exclude each other");
    ExpectOneLineAndCode2(command + courtyard + out + "--lighting a.jsonl --weather clear",
                          "--weather excludes --lighting");
  }
  // What changes an estimate alone.
  for (const char* option : {"--samples 50", "--no-filter"}) {
    ExpectOneLineAndCode2("run " + courtyard + out + "--lighting a.jsonl " + option,
                          "--lighting excludes " + option_of(option));
  }
  // A name that is mistyped is no video.
  ExpectOneLineAndCode2(
      "run /no/such/folder" + at_courtyard + "--start-time 2026-06-21T10:00:00Z --every 10s",
      "/no/such/folder: ");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "nothing was begun";
}

TEST_F(CommandLine, PrintsTheSunAsJson) {
  const Ended ended = Call("sun --site 57.0488,9.9217,15 --time 2005-06-21T09:50:00Z --json");
  EXPECT_EQ(ended.exit_code, 0);
  for (const char* key : {"azimuth_deg",
                          "elevation_deg",
                          "direction_enu",
                          "apparent_elevation_deg",
                          "apparent_direction_enu",
                          "angular_radius_deg",
                          "air_mass"}) {
    EXPECT_THAT(ended.output, HasSubstr(std::string("\"") + key + "\""));
  }
  EXPECT_THAT(ended.output, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace pleinair::command_line_test
