#include "apps/site_command.h"

#include <CLI/CLI.hpp>

#include "apps/site_import_arguments.h"
#include "apps/site_mask_arguments.h"
#include "apps/site_place_arguments.h"

namespace pleinair {

void AddSite(CLI::App& app, Work& work) {
  CLI::App& site = *app.add_subcommand("site", "Set up a site");
  site.require_subcommand(1);
  site.footer("Example: pleinair site place mysite --object 0 --pixel 320,400");
  AddSiteImportCommand(site, work);
  AddSiteMaskCommand(site, work);
  AddSitePlaceCommand(site, work);
}

}  // namespace pleinair
