// Rooms form a one-way chain: a file includes only from its own room and from those before it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace {

constexpr std::array rooms{"core", "mesh",   "material", "muscle", "contact",
                           "bone", "effect", "solver",   "scene",  "bindings"};

/// Place of the first folder of a path in the chain; -1 where it is no room.
int room_of(const std::string& path) {
  const std::string first = path.substr(0, path.find('/'));
  const auto found = std::find(rooms.begin(), rooms.end(), first);
  return path.find('/') == std::string::npos || found == rooms.end() ? -1 : static_cast<int>(found - rooms.begin());
}

/// Lines of `text` that include from a later room or from none; `path` is relative to cpp/.
std::string steps_back(const std::string& path, std::istream& text, int& includes) {
  std::string line, faults;
  while (std::getline(text, line)) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#' || line.find("include") == std::string::npos) continue;
    const std::size_t open = line.find('"');
    if (open == std::string::npos) continue;
    ++includes;
    const int room = room_of(line.substr(open + 1));
    if (room < 0 || room > room_of(path)) faults += path + ": " + line + "\n";
  }
  return faults;
}

}  // namespace

TEST_CASE("rooms: no file includes from a later room") {
  const std::filesystem::path root = std::filesystem::path(GLOSSA_SOURCE_DIR) / "cpp";
  int files = 0, includes = 0;
  std::string faults;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".hpp" && extension != ".cpp") continue;
    const std::string path = entry.path().lexically_relative(root).generic_string();
    INFO(path);
    CHECK(room_of(path) >= 0);
    std::ifstream text(entry.path());
    faults += steps_back(path, text, includes);
    ++files;
  }
  CHECK(faults == "");
  CHECK(files > 40);
  CHECK(includes > 80);
}

TEST_CASE("rooms: a step back is seen") {
  const auto faults = [](const std::string& path, const std::string& line) {
    std::istringstream text(line);
    int includes = 0;
    return steps_back(path, text, includes);
  };
  CHECK(faults("mesh/a.hpp", "#include \"scene/b.hpp\"") != "");
  CHECK(faults("mesh/a.hpp", "  #  include \"effect/b.hpp\"") != "");
  CHECK(faults("mesh/a.hpp", "#include \"b.hpp\"") != "");
  CHECK(faults("solver/a.hpp", "#include \"effect/b.hpp\"") == "");
  CHECK(faults("solver/a.hpp", "#include \"solver/b.hpp\"\n#include <vector>") == "");
}
