#include "mesh/quadratic_cells.hpp"

#include <algorithm>
#include <optional>

#include <Eigen/LU>

#include "core/error.hpp"
#include "mesh/hex_element.hpp"
#include "mesh/quadratic_hex.hpp"

namespace glossa {
namespace {

constexpr Index none = -1;

// Corners as bits: bit d is set where natural coordinate d is 1.
std::size_t bits_of(std::size_t corner) {
  std::size_t bits = 0;
  for (std::size_t d = 0; d < 3; ++d)
    if (hex::corner[corner][d] > 0) bits |= std::size_t{1} << d;
  return bits;
}

std::size_t corner_of(std::size_t bits) {
  for (std::size_t a = 0; a < 8; ++a)
    if (bits_of(a) == bits) return a;
  return 0;
}

// Nodes of a hexahedron by the bits of their corners.
std::array<Index, 8> by_bits(const Hexahedron& hexahedron) {
  std::array<Index, 8> result{};
  for (std::size_t bits = 0; bits < 8; ++bits) result[bits] = hexahedron[corner_of(bits)];
  return result;
}

struct Group {
  std::array<Index, 27> node;
  std::array<Index, 8> octant;
};

class Grouping {
 public:
  explicit Grouping(const HexMesh& mesh) : around_(static_cast<std::size_t>(mesh.node_count())) {
    for (const Hexahedron& hexahedron : mesh.hexahedra()) corners_.push_back(by_bits(hexahedron));
    for (std::size_t e = 0; e < corners_.size(); ++e)
      for (const Index node : corners_[e]) around_[static_cast<std::size_t>(node)].push_back(static_cast<Index>(e));
    group_of_.assign(corners_.size(), none);
  }

  QuadraticCells all() {
    for (std::size_t e = 0; e < corners_.size(); ++e)
      if (group_of_[e] == none)
        require(std::any_of(corners_[e].begin(), corners_[e].end(), [&](Index n) { return grow(n); }),
                "element Q2P1: hexahedron " + std::to_string(e) +
                    " belongs to no group of 2 x 2 x 2 hexahedra that fill its part of the body; divide the mesh by "
                    "two: Speaker.refined(), or an even resolution of the reference speaker");
    QuadraticCells result;
    result.cells.size = hex27::nodes;
    // In the order of their first hexahedra, whichever group they were found from.
    std::sort(groups_.begin(), groups_.end(), [](const Group& a, const Group& b) {
      return *std::min_element(a.octant.begin(), a.octant.end()) < *std::min_element(b.octant.begin(), b.octant.end());
    });
    for (const Group& group : groups_) {
      result.cells.nodes.insert(result.cells.nodes.end(), group.node.begin(), group.node.end());
      result.octants.push_back(group.octant);
    }
    return result;
  }

 private:
  [[nodiscard]] std::size_t place(Index hexahedron, Index node) const {
    const auto& corners = corners_[static_cast<std::size_t>(hexahedron)];
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), node) - corners.begin());
  }

  // The group around a node, if there is one: its natural coordinates are those of the first hexahedron around it.
  [[nodiscard]] std::optional<Group> group_around(Index centre) const {
    const std::vector<Index>& hexahedra = around_[static_cast<std::size_t>(centre)];
    if (hexahedra.size() != 8) return std::nullopt;
    // Neighbours of the centre: [axis][side]. Those of the first hexahedron lie away from its own corner; the
    // neighbour opposite is the one that shares no hexahedron with it.
    std::array<std::array<Index, 2>, 3> axis{};
    const std::size_t own = place(hexahedra[0], centre);
    for (std::size_t d = 0; d < 3; ++d) {
      const std::size_t side = (own >> d & 1U) == 0 ? 1 : 0;
      const Index neighbour = corners_[static_cast<std::size_t>(hexahedra[0])][own ^ (std::size_t{1} << d)];
      axis[d] = {none, none};
      axis[d][side] = neighbour;
      for (const Index h : hexahedra) {
        const auto& corners = corners_[static_cast<std::size_t>(h)];
        if (place(h, neighbour) < 8) continue;
        // Of this hexahedron's three neighbours of the centre one is opposite; it is the one in all such hexahedra.
        const std::size_t at_centre = place(h, centre);
        for (std::size_t j = 0; j < 3; ++j) {
          const Index candidate = corners[at_centre ^ (std::size_t{1} << j)];
          const bool apart = std::none_of(hexahedra.begin(), hexahedra.end(), [&](Index other) {
            return place(other, candidate) < 8 && place(other, neighbour) < 8;
          });
          if (apart) axis[d][1 - side] = candidate;
        }
      }
    }
    Group group;
    group.node.fill(none);
    group.octant.fill(none);
    for (const Index h : hexahedra) {
      const auto& corners = corners_[static_cast<std::size_t>(h)];
      const std::size_t at_centre = place(h, centre);
      std::array<std::size_t, 3> along{}, side{};  // of the hexahedron's own directions
      std::size_t octant = 0, axes = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const Index neighbour = corners[at_centre ^ (std::size_t{1} << j)];
        bool found = false;
        for (std::size_t d = 0; d < 3; ++d)
          for (std::size_t s = 0; s < 2; ++s)
            if (axis[d][s] == neighbour) {
              along[j] = d;
              side[j] = s;
              found = true;
            }
        if (!found) return std::nullopt;
        octant |= side[j] << along[j];
        axes |= std::size_t{1} << along[j];
      }
      if (axes != 7 || group.octant[octant] != none) return std::nullopt;
      group.octant[octant] = h;
      for (std::size_t step = 0; step < 8; ++step) {
        std::array<std::size_t, 3> at{1, 1, 1};
        for (std::size_t j = 0; j < 3; ++j)
          if (step >> j & 1U) at[along[j]] = 2 * side[j];
        Index& node = group.node[at[0] + 3 * at[1] + 9 * at[2]];
        const Index here = corners[at_centre ^ step];
        if (node != none && node != here) return std::nullopt;
        node = here;
      }
    }
    std::array<Index, 27> sorted = group.node;
    std::sort(sorted.begin(), sorted.end());
    if (sorted.front() == none || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return std::nullopt;
    return group;
  }

  // Centres of the groups that share a face with this one.
  void push_neighbours(const Group& group, std::vector<Index>& centres) const {
    for (std::size_t d = 0; d < 3; ++d)
      for (const std::size_t side : {0, 2}) {
        std::array<std::size_t, 3> at{1, 1, 1};
        at[d] = side;
        const Index middle = group.node[at[0] + 3 * at[1] + 9 * at[2]];
        for (const Index h : around_[static_cast<std::size_t>(middle)]) {
          if (std::find(group.octant.begin(), group.octant.end(), h) != group.octant.end()) continue;
          // Beyond the face, the one edge from its middle that leaves the face.
          const std::size_t own = place(h, middle);
          for (std::size_t j = 0; j < 3; ++j) {
            const Index next = corners_[static_cast<std::size_t>(h)][own ^ (std::size_t{1} << j)];
            if (std::find(group.node.begin(), group.node.end(), next) == group.node.end()) centres.push_back(next);
          }
        }
      }
  }

  // Groups everything connected with the group around `first`; changes nothing if that fails.
  bool grow(Index first) {
    const std::size_t before = groups_.size();
    std::vector<Index> centres{first};
    bool fits = true;
    while (fits && !centres.empty()) {
      const Index centre = centres.back();
      centres.pop_back();
      const std::vector<Index>& hexahedra = around_[static_cast<std::size_t>(centre)];
      const Index known = hexahedra.empty() ? none : group_of_[static_cast<std::size_t>(hexahedra[0])];
      if (known != none && groups_[static_cast<std::size_t>(known)].node[13] == centre) continue;
      const std::optional<Group> group = group_around(centre);
      fits = group.has_value() && std::all_of(group->octant.begin(), group->octant.end(),
                                              [&](Index h) { return group_of_[static_cast<std::size_t>(h)] == none; });
      if (!fits) break;
      for (const Index h : group->octant) group_of_[static_cast<std::size_t>(h)] = static_cast<Index>(groups_.size());
      groups_.push_back(*group);
      push_neighbours(*group, centres);
    }
    if (!fits) {
      groups_.resize(before);
      for (Index& group : group_of_)
        if (group >= static_cast<Index>(before)) group = none;
    }
    return fits;
  }

  std::vector<std::array<Index, 8>> corners_;
  std::vector<std::vector<Index>> around_;
  std::vector<Index> group_of_;
  std::vector<Group> groups_;
};

}  // namespace

QuadraticCells quadratic_cells(const HexMesh& mesh) {
  QuadraticCells result = Grouping(mesh).all();
  for (std::size_t c = 0; c < result.octants.size(); ++c)
    for (std::size_t q = 0; q < hex27::points; ++q) {
      const hex27::NodeGradients gradient = hex27::shape_gradient(hex27::gauss_point(q).xi);
      Matrix3 jacobian = Matrix3::Zero();
      for (std::size_t a = 0; a < hex27::nodes; ++a)
        jacobian += at(mesh.nodes(), result.cells.begin(c)[a]) * gradient.col(static_cast<Eigen::Index>(a)).transpose();
      require(jacobian.determinant() > 0.0,
              "element Q2P1: the cell of 27 nodes around hexahedron " + std::to_string(result.octants[c][0]) +
                  " is inverted or degenerate; its eight hexahedra differ too much in shape");
    }
  return result;
}

}  // namespace glossa
