// `pleinair doctor`: what works on this machine, what is missing, and what to do about it.
#pragma once

#include <string>

namespace pleinair {

// Looks at OpenGL, processor, clock, cameras, optional models, cache folder and libraries, and
// returns one line for each, in JSON or as text:
//
//   ok       works
//   missing  not there, and only some uses need it: the line says which, and how to get it
//   broken   recordings cannot be worked on, or times would be wrong, until it is repaired
//
// `all_well` is false where something is broken. Makes and removes OpenGL contexts on the calling
// thread; changes nothing on the disc.
std::string RunDoctorCommand(bool json, bool* all_well);

}  // namespace pleinair
