// Composites of a recorded sequence, one PNG a frame: composite_sequence SEQUENCE FOLDER
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>

#include <pleinair/scene/image_io.h>
#include <pleinair/session/sequence_session.h>

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("expected a sequence and a folder for the composites");
  std::filesystem::create_directories(argv[2]);
  pleinair::SequenceSession session({.sequence = argv[1]});
  while (const auto step = session.Next()) {
    if (step->result) {
      const std::string name = std::to_string(step->frame->index) + ".png";
      pleinair::WritePng(std::filesystem::path(argv[2]) / name, session.Show(*step));
    } else {
      std::cerr << step->result.error().reason << '\n';
    }
  }
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
