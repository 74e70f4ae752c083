#include "apps/site_check_arguments.h"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/settings_arguments.h"
#include "apps/site_check_command.h"

namespace pleinair {

void AddSiteCheckCommand(CLI::App& site, Work& work) {
  auto options = std::make_shared<SiteCheckOptions>();
  auto given = std::make_shared<GivenSettings>();
  CLI::App& check = *site.add_subcommand(
      "check", "What is wrong with a site, and how well its light will be known, hour by hour");
  check.footer(
      "Ends with 0 where nothing is found to be wrong, with 1 after a warning, with 2 on bad "
      "input.\nExample: pleinair site check datasets/samples/courtyard --day 2005-06-21 --out "
      "check");
  check.add_option("site", options->session.sequence, "folder with site.json or sequence.json")
      ->type_name("FOLDER")
      ->required();
  check
      .add_option("--day",
                  options->day,
                  "YYYY-MM-DD (default: of the first frame; today where there is none)")
      ->type_name("DATE");
  check.add_option("--step", options->step_min, "from one hour to the next, in minutes")
      ->check(CLI::Range(1, 1440));
  check.add_option("--out", options->out, "folder for day.png, the day as a picture")
      ->type_name("FOLDER");
  AddFrames(check, options->session.frames);
  check.add_flag("--json", options->json, "print JSON");
  AddSettings(check, *given);
  AddCache(check, options->session.cache);
  check.parse_complete_callback([options, given] { given->ApplyTo(options->session); });
  check.callback([options, &work] {
    work = [options] {
      bool is_good = false;
      Print(RunSiteCheck(*options, &is_good));
      return is_good ? 0 : 1;
    };
  });
}

}  // namespace pleinair
