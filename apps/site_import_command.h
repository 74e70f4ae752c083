// `pleinair site import`: a site and a sequence from a reconstruction of photographs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/reconstruction/site_import.h"

namespace pleinair {

struct SiteImportCommandOptions {
  SiteImportOptions import;  // Without what the texts below say.
  std::optional<double> length_m;
  std::string between;                // "ID,ID" or "PICTURE,X1,Y1,X2,Y2".
  std::string site;                   // As ParseSite takes it; empty: by the photographs.
  std::vector<std::string> headings;  // "PICTURE,DEG" or "PICTURE,DEG,SIGMA".
  std::string utc_offset;             // "+02:00", "Z"; empty: by the photographs.
  std::filesystem::path times;        // CSV: PICTURE,TIME,...; empty: by the photographs.
  std::filesystem::path marks;        // CSV: PICTURE,X,Y,SURFACE; empty: surfaces are found.
};

// Returns what is to be printed. Throws std::runtime_error or std::invalid_argument, one line.
std::string RunSiteImport(const SiteImportCommandOptions& options);

}  // namespace pleinair
