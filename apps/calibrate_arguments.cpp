#include "apps/calibrate_arguments.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "apps/calibrate_command.h"
#include "apps/calibrate_lens_command.h"
#include "apps/calibrate_markers_command.h"
#include "apps/calibrate_north_command.h"
#include "apps/calibrate_pose_command.h"
#include "apps/one_of.h"
#include "calib/marker_detection.h"

namespace pleinair {
namespace {

struct CommandName {
  const char* name;
  const char* what;
};

// The subcommand that `run` does, with its options filled in.
template <typename Options>
CLI::App& AddCalibration(CLI::App& calibrate,
                         Work& work,
                         const CommandName& named,
                         const std::shared_ptr<Options>& options,
                         std::string (*run)(const Options&)) {
  CLI::App& command = *calibrate.add_subcommand(named.name, named.what);
  command.callback(
      [options, run, &work] { work = [options, run] { return Print(run(*options)); }; });
  return command;
}

void AddExposures(CLI::App& command, std::vector<double>& exposures) {
  command
      .add_option("--exposures",
                  exposures,
                  "exposure (seconds, or time x ISO / N^2) of each picture (default: from EXIF)")
      ->delimiter(',')
      ->check(Positive());
}

void AddCalibrateNorth(CLI::App& calibrate, Work& work) {
  auto options = std::make_shared<CalibrateNorthOptions>();
  CLI::App& north =
      AddCalibration(calibrate,
                     work,
                     {"north", "How far the model's north is off, from the shadows in frames"},
                     options,
                     RunCalibrateNorth);
  north.footer("Example: pleinair calibrate north datasets/samples/courtyard");
  north.add_option("sequence", options->sequence, "folder with sequence.json")
      ->type_name("FOLDER")
      ->required();
  AddFrames(north, options->frames);
  north
      .add_option("--model-north",
                  options->model_north,
                  "north that the model's +Y is meant to be: true, grid (UTM) or magnetic")
      ->transform(OneOf<NorthKind>({{"true", NorthKind::kTrue},
                                    {"grid", NorthKind::kGrid},
                                    {"magnetic", NorthKind::kMagnetic}}))
      ->type_name("NORTH")
      ->default_str("true");
  north
      .add_option("--magnetic-model",
                  options->magnetic.name,
                  "of GeographicLib, for --model-north magnetic")
      ->type_name("NAME");
  north
      .add_option("--magnetic-folder",
                  options->magnetic.folder,
                  "folder with the magnetic model (default: GeographicLib's)")
      ->type_name("FOLDER");
  north
      .add_option("--shadow-edges",
                  options->shadow_edges,
                  "CSV: FRAME,X,Y (pixels), places on the edges of shadows that the mesh casts; "
                  "then only they are used")
      ->type_name("FILE");
  north.add_flag("--json", options->json, "print JSON");
}

// `lens`, or `fisheye` with its model given.
void AddCalibrateLens(CLI::App& calibrate,
                      Work& work,
                      const CommandName& named,
                      std::optional<LensModel> model) {
  auto options = std::make_shared<CalibrateLensOptions>();
  options->model = model;
  CLI::App& lens = AddCalibration(calibrate, work, named, options, RunCalibrateLens);
  lens.footer(fmt::format("Example: pleinair calibrate {} boards/*.jpg --board 8x6 --out {}",
                          named.name,
                          model ? "sky.json" : "lens.json"));
  lens.add_option("pictures", options->pictures, "pictures of the board")
      ->type_name("PICTURE")
      ->required();
  lens.add_option("--board", options->board, "inner corners, COLUMNSxROWS")
      ->type_name("COLUMNSxROWS")
      ->required();
  CLI::Option* charuco = lens.add_flag(
      "--charuco",
      options->charuco,
      "the board is OpenCV's ChArUco, with one square more than corners a side; part of it is "
      "enough");
  lens.add_option(
          "--dictionary", options->markers.dictionary, "of its markers: 4x4_50, 5x5_100, ...")
      ->type_name("NAME")
      ->needs(charuco)
      ->check(CLI::IsMember(MarkerDictionaryNames()))
      ->capture_default_str();
  lens.add_option(
          "--marker-share", options->markers.side_share, "side of a marker over that of a square")
      ->needs(charuco)
      ->check(CLI::Range(0.05, 0.95))
      ->capture_default_str();
  if (!model) {
    lens.add_option("--model",
                    options->model,
                    "pinhole or fisheye (default: what predicts held-out pictures better)")
        ->transform(
            OneOf<LensModel>({{"pinhole", LensModel::kPinhole}, {"fisheye", LensModel::kFisheye}}))
        ->type_name("MODEL");
  }
  lens.add_option(
          "--fov-deg", options->fov_deg, "of a fish-eye: full angle (default: the picture's)")
      ->check(CLI::Range(1.0, 360.0));
  lens.add_option(
          "--always-use",
          options->always_used,
          "picture, of those given, that is used whatever its blur and fit; may be repeated")
      ->type_name("PICTURE")
      ->allow_extra_args(false);
  lens.add_flag("--force",
                options->force,
                "write a lens that misses the corners by more than 1 px, or has fx and fy more "
                "than 3 % apart, too");
  lens.add_option("--out", options->out, "the lens's file: `camera`, or a fish-eye's")
      ->type_name("FILE");
  lens.add_option("--site",
                  options->site,
                  "folder with site.json or sequence.json: the lens becomes its `camera`, or with "
                  "fisheye.json its `fisheye`")
      ->type_name("FOLDER");
}

void AddCalibrateMarkers(CLI::App& calibrate, Work& work) {
  auto markers = std::make_shared<CalibrateMarkersOptions>();
  CLI::App& board =
      AddCalibration(calibrate,
                     work,
                     {"markers", "Places of ArUco or AprilTag markers, from pictures of them"},
                     markers,
                     RunCalibrateMarkers);
  board.footer(
      "Example: pleinair calibrate markers tags/*.jpg --camera courtyard --size 0.2 --out "
      "board.json");
  board.add_option("pictures", markers->pictures, "pictures with two markers or more each")
      ->type_name("PICTURE")
      ->required();
  board
      .add_option("--camera",
                  markers->camera,
                  "A sequence.json with `camera` (the lens; all else may be absent), or its folder")
      ->type_name("FILE")
      ->required();
  board.add_option("--size", markers->size_m, "side of the black border, in metres")
      ->required()
      ->check(Positive());
  board.add_option("--dictionary", markers->dictionary, "OpenCV's: apriltag_36h11, 4x4_50, ...")
      ->type_name("NAME")
      ->check(CLI::IsMember(MarkerDictionaryNames()));
  board.add_option("--reference",
                   markers->reference,
                   "id of the marker at the origin (default: the one that most pictures show)");
  board
      .add_option("--anchor",
                  markers->anchor,
                  "board file with the places of some of the markers in the world")
      ->type_name("FILE");
  board.add_option("--out", markers->out, "the board file")->type_name("FILE")->required();
}

void AddCalibratePose(CLI::App& calibrate, Work& work) {
  auto pose = std::make_shared<CalibratePoseOptions>();
  CLI::App& command =
      AddCalibration(calibrate,
                     work,
                     {"pose", "Where the camera stood, from picked points, edges or markers"},
                     pose,
                     RunCalibratePose);
  command.footer(
      "Example: pleinair calibrate pose site --points picks.csv --out site/site.json\n"
      "Example: pleinair calibrate pose site --edges frame.png --out site/site.json\n"
      "Example: pleinair calibrate pose site --near-stated --edges a.png b.png --out "
      "site/site.json\n"
      "Example: pleinair calibrate pose walk --markers board.json --out walk/with_poses.json");
  command
      .add_option("site",
                  pose->site,
                  "folder with site.json or sequence.json; for --points, a file with `camera`, too")
      ->type_name("FOLDER")
      ->required();
  CLI::Option* points =
      command
          .add_option(
              "--points", pose->points, "CSV: X_PX,Y_PX,X_M,Y_M,Z_M, a row for each picked point")
          ->type_name("FILE");
  command
      .add_option("--inlier-px",
                  pose->inlier_px,
                  "how far off a pick may be before it is left out (default: 3)")
      ->needs(points)
      ->check(Positive());
  CLI::Option* edges =
      command
          .add_option("--edges",
                      pose->edges,
                      "A picture of the camera: the stated camera_from_world is moved until the "
                      "mesh's edges lie on the picture's")
          ->type_name("PICTURE")
          ->allow_extra_args(false);
  edges->excludes(points);
  CLI::Option* near_stated = command.add_flag(
      "--near-stated",
      pose->near_stated,
      "the stated camera_from_world is good to half a degree or so: where two poses fit the "
      "points, "
      "take the one nearer to it; by edges, stay near it, and move only as far as they are sure");
  command
      .add_option("pictures",
                  pose->more_edges,
                  "with --edges and --near-stated: more pictures of the camera, after the site")
      ->type_name("PICTURE")
      ->needs(edges);
  command.add_option("--mesh", pose->mesh, "for --edges (default: the site's scene.mesh)")
      ->type_name("FILE")
      ->needs(edges);
  command
      .add_option("--search-px",
                  pose->search_px,
                  "how far the stated pose may put edges from where they are (default: 20; with "
                  "--near-stated a sixtieth of the picture's width)")
      ->needs(edges)
      ->check(CLI::Range(2.0, 1000.0));
  CLI::Option* markers =
      command.add_option("--markers", pose->markers, "board file of `calibrate markers`")
          ->type_name("FILE");
  markers->excludes(points)->excludes(edges)->excludes(near_stated);
  AddFrames(command, pose->frames)->needs(markers);
  command
      .add_option("--out",
                  pose->out,
                  "copy of the file with the pose in it, which may be the file itself; paths in "
                  "it stay relative to its folder")
      ->type_name("FILE");
}

}  // namespace

void AddCalibrate(CLI::App& app, Work& work) {
  CLI::App& calibrate = *app.add_subcommand("calibrate", "Make the files that describe cameras");
  calibrate.require_subcommand(1);
  calibrate.footer("Example: pleinair calibrate lens boards/*.jpg --board 8x6 --out lens.json");
  AddCalibrateNorth(calibrate, work);
  AddCalibrateLens(
      calibrate, work, {"lens", "A pinhole or fish-eye lens from pictures of a board"}, {});
  AddCalibrateLens(calibrate,
                   work,
                   {"fisheye", "The same, of a lens known to be a fish-eye"},
                   LensModel::kFisheye);
  AddCalibrateMarkers(calibrate, work);
  AddCalibratePose(calibrate, work);

  auto response = std::make_shared<CalibrateResponseOptions>();
  CLI::App& curve =
      AddCalibration(calibrate,
                     work,
                     {"response", "A camera's response from brackets or a ColorChecker"},
                     response,
                     RunCalibrateResponse);
  curve.footer("Example: pleinair calibrate response bracket/*.jpg --out response.json");
  curve.add_option("pictures", response->pictures, "PNG or JPEG")->type_name("PICTURE")->required();
  AddExposures(curve, response->exposures);
  curve.add_flag("--chart", response->chart, "each picture shows a ColorChecker: use its greys");
  curve
      .add_option(
          "--corners",
          response->corners,
          "corners of the chart: X,Y of dark skin's, bluish green's, black's, white's outer corner "
          "(default: found)")
      ->type_name("X,Y,...");
  curve.add_option("--curve", response->curve, "for the chart: monotone or logarithmic")
      ->type_name("NAME")
      ->check(CLI::IsMember({"monotone", "logarithmic"}));
  curve.add_flag("--force",
                 response->force,
                 "write a bracket's curve that the pictures miss by more than 10 %, or that is "
                 "nearly flat, too");
  curve.add_option("--out", response->out, "the response file")->type_name("FILE");
  curve.add_option("--site", response->site, "folder of the site whose camera gets the response")
      ->type_name("FOLDER");

  auto merge = std::make_shared<CalibrateMergeOptions>();
  CLI::App& hdr = AddCalibration(calibrate,
                                 work,
                                 {"merge", "One HDR picture from an exposure bracket"},
                                 merge,
                                 RunCalibrateMerge);
  hdr.footer("Example: pleinair calibrate merge bracket/*.jpg --response r.json --out sky.exr");
  hdr.add_option("pictures", merge->pictures, "PNG or JPEG")->type_name("PICTURE")->required();
  AddExposures(hdr, merge->exposures);
  hdr.add_option("--response", merge->response, "srgb8 or a response file")->type_name("FILE");
  hdr.add_option("--out", merge->out, "EXR or HDR")->type_name("FILE")->required();

  auto average = std::make_shared<CalibrateAverageOptions>();
  CLI::App& mean =
      AddCalibration(calibrate,
                     work,
                     {"average", "The mean of HDR frames of a camera that stands still"},
                     average,
                     RunCalibrateAverage);
  mean.footer("Example: pleinair calibrate average frames/*.exr --out mean.exr");
  mean.add_option("frames", average->frames, "EXR or HDR")->type_name("PICTURE")->required();
  mean.add_option("--out", average->out, "EXR or HDR")->type_name("FILE")->required();

  auto colour = std::make_shared<CalibrateColourOptions>();
  CLI::App& tie =
      AddCalibration(calibrate,
                     work,
                     {"colour", "Tie a camera's colours to another's, or to the survey's"},
                     colour,
                     RunCalibrateColour);
  tie.footer(
      "Example: pleinair calibrate colour sky.json --pairs pairs.csv\n"
      "Example: pleinair calibrate colour site --from-picture frame.png --to-picture survey.exr "
      "--regions regions.csv");
  tie.add_option("camera",
                 colour->calibration,
                 "A fish-eye's file, or a folder with site.json or sequence.json: its camera")
      ->type_name("FILE")
      ->required();
  CLI::Option* pairs =
      tie.add_option(
             "--pairs", colour->pairs, "CSV: this camera's R,G,B, the other's R,G,B (linear)")
          ->type_name("FILE");
  CLI::Option* from = tie.add_option("--from-picture,--fisheye-picture",
                                     colour->from_picture,
                                     "of this camera; EXR, HDR or 8-bit")
                          ->type_name("PICTURE");
  CLI::Option* to = tie.add_option("--to-picture,--room-picture",
                                   colour->to_picture,
                                   "of the other, or the survey, in the same light")
                        ->type_name("PICTURE");
  CLI::Option* regions =
      tie.add_option("--regions",
                     colour->regions,
                     "CSV: X,Y,RADIUS (pixels) of a surface in each picture, or without "
                     "--to-picture X,Y,RADIUS,R,G,B (default: both show a ColorChecker)")
          ->type_name("FILE");
  from->excludes(pairs);
  to->needs(from);
  regions->needs(from);
  tie.add_option("--from-corners,--fisheye-corners",
                 colour->from_corners,
                 "of the chart, as for response (default: found)")
      ->type_name("X,Y,...");
  tie.add_option("--to-corners,--room-corners", colour->to_corners, "the same")
      ->type_name("X,Y,...");
  tie.add_option("--from-response,--fisheye-response",
                 colour->from_response,
                 "of an 8-bit picture (default: the site's, or srgb8)")
      ->type_name("FILE");
  tie.add_option("--to-response,--room-response", colour->to_response, "the same of the other")
      ->type_name("FILE");
  tie.add_flag("--matrix", colour->matrix, "of a fish-eye: a 3x3 matrix, not a factor a channel");
  tie.add_flag(
      "--force", colour->force, "write factors of pairs that are off by more than 40 % (rms), too");
  tie.add_option("--out", colour->out, "where to write (default: the same file)")
      ->type_name("FILE");

  auto orientation = std::make_shared<CalibrateOrientationOptions>();
  CLI::App& north =
      AddCalibration(calibrate,
                     work,
                     {"orientation", "Up and north of a fish-eye, from marks or the sun's image"},
                     orientation,
                     RunCalibrateOrientation);
  north.footer(
      "Example: pleinair calibrate orientation sky.json --site 50.36,7.56,75 --levelled"
      " --sun noon.exr --time 2007-03-20T11:40:00Z");
  north.add_option("calibration", orientation->calibration, "the fish-eye's file")
      ->type_name("FILE")
      ->required();
  north.add_option("--marks", orientation->marks, "CSV: X,Y (pixels), EAST,NORTH,UP")
      ->type_name("FILE");
  north.add_option("--sun", orientation->sun_pictures, "picture with the sun in it; repeatable")
      ->type_name("PICTURE");
  north.add_option("--time", orientation->times, "UTC of each of these")->type_name("TIME");
  north.add_option("--site", orientation->site, "LAT,LON[,H], for the sun")
      ->type_name("LAT,LON[,H]");
  north.add_flag(
      "--levelled", orientation->levelled, "the axis points to the zenith: one sun is enough");
  north.add_flag("--mirrored", orientation->mirrored, "the picture is mirrored, as a map");
  north.add_flag("--force",
                 orientation->force,
                 "write an orientation that misses the sun by more than 5 deg, or looks down, too");
  north.add_option("--out", orientation->out, "where to write (default: the same file)")
      ->type_name("FILE");
}

}  // namespace pleinair
