#include "apps/site_import_arguments.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "apps/site_import_command.h"

namespace pleinair {

void AddSiteImportCommand(CLI::App& site, Work& work) {
  auto options = std::make_shared<SiteImportCommandOptions>();
  CLI::App& command =
      *site.add_subcommand("import", "A site and a sequence from a COLMAP or OpenSfM model");
  command.footer(
      "Example: pleinair site import sparse/0 --photos images --out mysite --length 2.1 --between "
      "door.jpg,820,1130,824,1702 --utc-offset +02:00");
  command
      .add_option("reconstruction",
                  options->import.reconstruction,
                  "folder of COLMAP's cameras, images and points3D (.bin or .txt), or OpenSfM's "
                  "reconstruction.json")
      ->type_name("MODEL")
      ->required();
  command
      .add_option("--photos",
                  options->import.photos,
                  "folder of the photographs, which the model's names are relative to")
      ->type_name("FOLDER")
      ->required();
  command.add_option("--out", options->import.out, "folder to make, absent or empty")
      ->type_name("FOLDER")
      ->required();

  command
      .add_option("--length",
                  options->length_m,
                  "a known length in metres (default: the scale that the photographs' GPS implies)")
      ->check(Positive().description(""))
      ->type_name("METRES")
      ->group("Place");
  command
      .add_option("--between",
                  options->between,
                  "its ends: ids of two of the model's points, or two places in a picture where "
                  "the model has points")
      ->type_name("ID,ID|PICTURE,X1,Y1,X2,Y2")
      ->group("Place");
  command
      .add_option("--site",
                  options->site,
                  "where that is, in degrees and metres (default: by the photographs' GPS)")
      ->type_name("LAT,LON[,H]")
      ->group("Place");
  command
      .add_option("--heading",
                  options->headings,
                  "azimuth that the camera of a picture looks to, in degrees clockwise from true "
                  "north, and its standard deviation (10); repeatable")
      ->type_name("PICTURE,DEG[,SIGMA]")
      ->default_str("")
      ->group("Place");
  command
      .add_option("--utc-offset",
                  options->utc_offset,
                  "what the camera's clock is ahead of UTC, where the photographs do not say")
      ->type_name("+HH:MM")
      ->group("Time");
  command
      .add_option("--times",
                  options->times,
                  "CSV of PICTURE,TIME (UTC, ISO 8601), in place of the photographs' own times")
      ->type_name("FILE")
      ->group("Time");

  command
      .add_option("--marks",
                  options->marks,
                  "CSV of PICTURE,X,Y,SURFACE: corners of surfaces (three or more in one picture, "
                  "in order) or places on them; `ground` is the ground (default: found)")
      ->type_name("FILE")
      ->group("Surfaces");
  command
      .add_option("--tolerance",
                  options->import.tolerance_m,
                  "of points to their plane (default: half a percent of the median distance)")
      ->check(Positive().description(""))
      ->type_name("METRES")
      ->default_str("")
      ->group("Surfaces");
  command
      .add_option("--camera-height",
                  options->import.surfaces.camera_height_m,
                  "of the lowest camera above the ground, where no points show the ground")
      ->check(NotNegative().description(""))
      ->type_name("METRES")
      ->group("Surfaces");
  command
      .add_option("--border",
                  options->import.surfaces.border_m,
                  "by which the ground extends beyond walls and cameras")
      ->check(NotNegative().description(""))
      ->type_name("METRES")
      ->group("Surfaces");

  command
      .add_option("--camera",
                  options->import.camera,
                  "of the model, whose pictures become frames (default: the one with the most)")
      ->type_name("ID")
      ->group("Frames");
  command
      .add_option("--longest-side",
                  options->import.longest_side_px,
                  "photographs are reduced to; 0: they stay as they are")
      ->check(CLI::Range(0, 65536).description(""))
      ->type_name("PIXELS")
      ->group("Frames");
  command.callback(
      [options, &work] { work = [options] { return Print(RunSiteImport(*options)); }; });
}

}  // namespace pleinair
