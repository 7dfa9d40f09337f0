// Reads a Gmsh MSH 4.1 text file of tetrahedra into the arrays that the service takes.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

struct Group {
  std::string name;
  int dimension;
  std::vector<int32_t> members;
};

struct MeshArrays {
  std::vector<double> coordinates;     // [vertices, 3]
  std::vector<int32_t> cells, facets;  // [cells, 4], [facets, 3]
  std::vector<Group> groups;
};

inline MeshArrays read_msh(const std::string& path) {
  std::ifstream file(path);
  MeshArrays mesh;
  std::map<std::pair<int, long>, size_t> named;   // dimension and physical number: group
  std::map<std::pair<int, long>, size_t> owner;   // dimension and entity: group
  std::map<long, int32_t> vertex;                 // node number: index
  std::string word;
  while (file >> word) {
    if (word == "$PhysicalNames") {
      size_t count;
      file >> count;
      while (count-- > 0) {
        Group group;
        long number;
        file >> group.dimension >> number >> group.name;
        group.name = group.name.substr(1, group.name.size() - 2);
        named[{group.dimension, number}] = mesh.groups.size();
        mesh.groups.push_back(group);
      }
    } else if (word == "$Entities") {
      size_t counts[4];
      for (size_t& count : counts) file >> count;
      for (int dimension = 0; dimension < 4; ++dimension) {
        while (counts[dimension]-- > 0) {
          long entity, number;
          double skipped;
          size_t count;
          file >> entity;
          for (int box = 0; box < (dimension == 0 ? 3 : 6); ++box) file >> skipped;
          for (file >> count; count > 0; --count) {
            file >> number;
            owner[{dimension, entity}] = named.at({dimension, number});
          }
          if (dimension > 0) {
            for (file >> count; count > 0; --count) file >> number;
          }
        }
      }
    } else if (word == "$Nodes") {
      size_t blocks, skipped;
      file >> blocks >> skipped >> skipped >> skipped;
      while (blocks-- > 0) {
        size_t count;
        file >> skipped >> skipped >> skipped >> count;
        std::vector<long> numbers(count);
        for (long& number : numbers) file >> number;
        for (long number : numbers) {
          vertex[number] = static_cast<int32_t>(mesh.coordinates.size() / 3);
          for (int axis = 0; axis < 3; ++axis) {
            double x;
            file >> x;
            mesh.coordinates.push_back(x);
          }
        }
      }
    } else if (word == "$Elements") {
      size_t blocks, skipped;
      file >> blocks >> skipped >> skipped >> skipped;
      while (blocks-- > 0) {
        int dimension, type;
        long entity, node;
        size_t count;
        file >> dimension >> entity >> type >> count;
        const int nodes = type == 15 ? 1 : type == 1 ? 2 : type == 2 ? 3 : type == 4 ? 4 : 0;
        if (nodes == 0) throw std::runtime_error("elements of first order are expected");
        const auto group = owner.find({dimension, entity});
        while (count-- > 0) {
          file >> skipped;
          std::vector<int32_t>& all = dimension == 3 ? mesh.cells : mesh.facets;
          const auto index = static_cast<int32_t>(all.size() / nodes);
          const bool kept = dimension == 3 || (dimension == 2 && group != owner.end());
          for (int corner = 0; corner < nodes; ++corner) {
            file >> node;
            if (kept) all.push_back(vertex.at(node));
          }
          if (kept && group != owner.end()) mesh.groups[group->second].members.push_back(index);
        }
      }
    }
  }
  if (mesh.cells.empty()) throw std::runtime_error(path + ": no tetrahedra in MSH 4.1 text");
  return mesh;
}
