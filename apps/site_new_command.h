// `pleinair site new`: a site's folder, part by part.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pleinair {

// What is given; empty: not now.
struct SiteNewOptions {
  std::filesystem::path folder;
  std::string place;  // LAT,LON[,H]
  std::filesystem::path mesh;
  std::string mesh_units = "m";
  std::string mesh_up = "z";
  std::vector<std::string> diffuse_regions;
  std::string camera;          // Device, identity or photograph.
  std::string earlier_camera;  // An earlier answer's, for the pose.
  std::filesystem::path lens;  // With `camera`.
  std::filesystem::path pose;
  std::string camera_at;  // X,Y,Z
  std::string camera_to;
  std::filesystem::path environment;
  std::string environment_at;
  std::string environment_time;
  std::string albedos;  // "known" or "assumed".
  std::filesystem::path object;
  std::string object_units = "m";
  std::string object_up = "z";
  std::string object_at;
  double object_turn_deg = 0.0;
};

// A person's answer to a question, without its line end; none: no more answers.
using Ask = std::function<std::optional<std::string>(const std::string& question)>;

// Applies what is given, then asks for the parts that are still missing, where there is somebody to
// ask. An empty answer leaves a part for another time, an unusable answer is asked for again.
// Returns the state of each part and the next command. Throws std::runtime_error or
// std::invalid_argument, one line, for unusable options; parts before stay written.
std::string RunSiteNew(const SiteNewOptions& options, const Ask& ask);

// On a terminal, both ways; else nobody is to be asked: empty.
Ask AskOnTerminal();

}  // namespace pleinair
