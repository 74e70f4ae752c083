#include "apps/site_command.h"

#include <CLI/CLI.hpp>

#include "apps/site_check_arguments.h"
#include "apps/site_import_arguments.h"
#include "apps/site_mask_arguments.h"
#include "apps/site_new_arguments.h"
#include "apps/site_place_arguments.h"

namespace pleinair {

void AddSite(CLI::App& app, Work& work) {
  CLI::App& site = *app.add_subcommand("site", "Set up a site, and check it");
  site.require_subcommand(1);
  site.footer("Example: pleinair site check datasets/samples/courtyard");
  AddSiteNewCommand(site, work);
  AddSiteImportCommand(site, work);
  AddSiteCheckCommand(site, work);
  AddSiteMaskCommand(site, work);
  AddSitePlaceCommand(site, work);
}

}  // namespace pleinair
