#include "apps/site_place_arguments.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "apps/site_place_command.h"

namespace pleinair {

void AddSitePlaceCommand(CLI::App& site, Work& work) {
  auto options = std::make_shared<SitePlaceOptions>();
  CLI::App& place =
      *site.add_subcommand("place", "Put a virtual object onto a surface, and write where it is");
  place.footer(
      "Example: pleinair site place mysite --object teapot.obj --pixel 320,400 --scale 0.5");
  place
      .add_option(
          "site", options->folder, "folder with site.json or sequence.json, which is changed")
      ->type_name("SITE|SEQUENCE")
      ->required();
  place
      .add_option("--object",
                  options->object,
                  "which of the site's objects, from 0; or the mesh of a new one, which is copied "
                  "into the folder")
      ->type_name("INDEX|FILE")
      ->required();
  CLI::Option* const pixel =
      place
          .add_option(
              "--pixel", options->pixel, "onto the surface that this place of the picture shows")
          ->delimiter(',')
          ->expected(2)
          ->option_text("X,Y")
          ->group("Where");
  CLI::Option* const frame =
      place
          .add_option(
              "--frame", options->frame, "of a sequence, for --pixel, from 0 (default: the first)")
          ->check(CLI::NonNegativeNumber.description(""))
          ->type_name("N")
          ->default_str("")
          ->group("Where");
  CLI::Option* const at = place
                              .add_option("--at",
                                          options->at_m,
                                          "onto the surface next to this point of the world, in "
                                          "metres")
                              ->delimiter(',')
                              ->expected(3)
                              ->option_text("X,Y,Z")
                              ->group("Where");
  frame->needs(pixel);
  at->excludes(pixel);
  place.add_option("--turn-deg", options->turn_deg, "about its axis, counter-clockwise from above")
      ->type_name("DEG")
      ->default_str("");
  place.add_option("--lift", options->lift_m, "along its axis, off the surface")
      ->type_name("METRES")
      ->default_str("");
  place.add_option("--scale", options->scale, "its present size by this factor, about its foot")
      ->check(Positive().description(""))
      ->type_name("FACTOR")
      ->default_str("");
  CLI::Option* const remove =
      place.add_flag("--remove", options->remove, "take it out of the site; its files stay");
  remove->excludes(pixel)->excludes(at);
  place.callback([options, &work] { work = [options] { return Print(RunSitePlace(*options)); }; });
}

}  // namespace pleinair
