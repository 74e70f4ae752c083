#include "apps/site_new_arguments.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "apps/site_new_command.h"

namespace pleinair {

void AddSiteNewCommand(CLI::App& site, Work& work) {
  auto options = std::make_shared<SiteNewOptions>();
  CLI::App& command = *site.add_subcommand(
      "new", "Make a site's folder, or go on with it: asks for what is missing");
  command.footer(
      "Questions are asked on a terminal only; each has an option.\n"
      "Example: pleinair site new mysite --place 57.0488,9.9217,15 --mesh plan.obj --mesh-units "
      "cm");
  const auto is_unit = CLI::IsMember({"m", "cm", "mm", "ft", "in"});
  const auto is_up = CLI::IsMember({"y", "z"});
  const auto text = [&](const char* name, std::string& to, const char* type, const char* help) {
    return command.add_option(name, to, help)->type_name(type)->default_str("");
  };
  const auto file = [&](const char* name, std::filesystem::path& to, const char* help) {
    return command.add_option(name, to, help)->type_name("FILE")->default_str("");
  };
  command.add_option("site", options->folder, "folder, which is made where it is not there")
      ->type_name("DIR")
      ->required();
  text("--place", options->place, "LAT,LON[,H]", "degrees north and east, metres");
  file("--mesh", options->mesh, "walls and ground: OBJ, PLY, STL or glTF; converted and copied");
  command.add_option("--mesh-units", options->mesh_units, "m, cm, mm, ft or in")
      ->type_name("UNIT")
      ->check(is_unit);
  command
      .add_option("--mesh-up", options->mesh_up, "z, or y (not for glTF, which is turned anyway)")
      ->type_name("AXIS")
      ->check(is_up);
  command
      .add_option("--diffuse",
                  options->diffuse_regions,
                  "groups or materials whose surfaces may be sampled (default: all)")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->default_str("");
  text("--camera",
       options->camera,
       "DEVICE|PHOTO",
       "device or identity for live runs; or a photograph, whose EXIF data give a first lens");
  file("--lens", options->lens, "JSON file with `camera`, as calibrate lens writes it");
  CLI::Option* const pose =
      file("--pose", options->pose, "JSON file with camera_from_world, alone or in `camera`");
  text("--camera-at", options->camera_at, "X,Y,Z", "in place of --pose, roughly: where it stands")
      ->excludes(pose);
  text("--camera-to", options->camera_to, "X,Y,Z", "what the level camera looks at")
      ->excludes(pose);
  CLI::Option* const map =
      file("--environment", options->environment, "lat-long HDR map of the place; copied");
  text("--environment-at", options->environment_at, "X,Y,Z", "where it was taken")->needs(map);
  text("--environment-time", options->environment_time, "UTC", "when")->needs(map);
  text("--albedos", options->albedos, "known|assumed", "that the mesh's Kd is measured, or guessed")
      ->check(CLI::IsMember({"known", "assumed"}));
  CLI::Option* const object =
      file("--object", options->object, "virtual object to add: OBJ or glTF; copied");
  text("--object-at", options->object_at, "X,Y,Z", "where its origin stands")->needs(object);
  command.add_option("--object-units", options->object_units, "as --mesh-units")
      ->type_name("UNIT")
      ->check(is_unit);
  command.add_option("--object-up", options->object_up, "as --mesh-up")
      ->type_name("AXIS")
      ->check(is_up);
  command.add_option("--object-turn-deg",
                     options->object_turn_deg,
                     "about the vertical, counter-clockwise from above");
  command.callback([options, &work] {
    work = [options] { return Print(RunSiteNew(*options, AskOnTerminal())); };
  });
}

}  // namespace pleinair
