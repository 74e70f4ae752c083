#include "apps/site_mask_arguments.h"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/site_mask_command.h"

namespace pleinair {

void AddSiteMaskCommand(CLI::App& site, Work& work) {
  auto options = std::make_shared<SiteMaskOptions>();
  CLI::App& mask = *site.add_subcommand(
      "mask", "Find what moves in a recording (cars, people, plants), and leave it out of samples");
  mask.footer("Example: pleinair site mask mysequence --overview moving.png --write");
  mask.add_option("sequence", options->session.sequence, "folder with sequence.json")
      ->type_name("SEQUENCE")
      ->required();
  mask.add_option("--out", options->out, "mask to write: 255 where nothing moves")
      ->type_name("PNG");
  mask.add_option("--overview",
                  options->overview,
                  "picture to write: the first frame, red where it is masked, blue where something "
                  "passed too seldom")
      ->type_name("PNG");
  mask.add_flag("--write",
                options->write,
                "make it the sequence's diffuse_mask, together with the one that it has");
  mask.add_option("--max-frames", options->frames, "frames to look at, spread over the recording")
      ->check(CLI::Range(3, 1000).description(""))
      ->type_name("N");
  mask.add_option("--least-change",
                  options->moving.least_change,
                  "change of light that is something else, as a natural logarithm of the ratio")
      ->check(Positive().description(""))
      ->type_name("LOG");
  mask.add_option("--least-share",
                  options->moving.least_share,
                  "of the frames in which a surface is hidden; and at least in two")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->type_name("SHARE");
  AddFrames(mask, options->session.frames);
  AddCache(mask, options->session.cache);
  mask.callback([options, &work] { work = [options] { return Print(RunSiteMask(*options)); }; });
}

}  // namespace pleinair
