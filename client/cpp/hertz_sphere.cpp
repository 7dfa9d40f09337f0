// Solves the scene of ../examples/hertz-sphere.toml through the service:
//   hertz_sphere SERVER MESH      (127.0.0.1:50051 ../examples/meshes/indent_l1.msh)
// Prints the force of the sphere on the body and the largest displacement.

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <random>
#include <string>

#include "mesh.hpp"
#include "signorini/v1/mesh_service.grpc.pb.h"
#include "signorini/v1/session_service.grpc.pb.h"

namespace pb = signorini::v1;

// On every call of a session: a proxy in front of several servers leads them all to the same one.
const char* const route = "x-signorini-session";

constexpr size_t kChunkBytes = 1 << 20;

void check(const grpc::Status& status) {
  // `status.error_details()` holds a google.rpc.Status with the reason for programs.
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

template <class Number>
void send(grpc::ClientWriter<pb::UploadMeshRequest>& writer, pb::MeshArray array, int group,
          const std::vector<Number>& values) {
  const auto* bytes = reinterpret_cast<const char*>(values.data());
  const size_t total = values.size() * sizeof(Number);
  for (size_t start = 0; start < total; start += kChunkBytes) {
    pb::UploadMeshRequest request;
    pb::MeshChunk* chunk = request.mutable_chunk();
    chunk->set_array(array);
    chunk->set_group_index(group);
    chunk->set_offset_elements(static_cast<int64_t>(start / sizeof(Number)));
    chunk->set_data(bytes + start, std::min(kChunkBytes, total - start));
    writer.Write(request);
  }
}

// Name of the mesh on the server, which computes its digest.
std::string upload(pb::MeshService::Stub& service, const MeshArrays& mesh,
                   const std::string& session) {
  grpc::ClientContext context;
  context.AddMetadata(route, session);
  pb::UploadMeshResponse answer;
  auto writer = service.UploadMesh(&context, &answer);
  pb::UploadMeshRequest first;
  pb::MeshHeader* header = first.mutable_header();
  header->set_cell_kind(pb::CELL_KIND_TETRAHEDRON);
  header->set_vertex_count(static_cast<int64_t>(mesh.coordinates.size() / 3));
  header->set_cell_count(static_cast<int64_t>(mesh.cells.size() / 4));
  header->set_facet_count(static_cast<int64_t>(mesh.facets.size() / 3));
  for (const Group& group : mesh.groups) {
    pb::MeshGroup* named = header->add_groups();
    named->set_name(group.name);
    named->set_kind(group.dimension == 3 ? pb::GROUP_KIND_CELLS : pb::GROUP_KIND_FACETS);
    named->set_member_count(static_cast<int64_t>(group.members.size()));
  }
  writer->Write(first);
  send(*writer, pb::MESH_ARRAY_COORDINATES, 0, mesh.coordinates);
  send(*writer, pb::MESH_ARRAY_CELLS, 0, mesh.cells);
  send(*writer, pb::MESH_ARRAY_FACETS, 0, mesh.facets);
  for (size_t index = 0; index < mesh.groups.size(); ++index) {
    send(*writer, pb::MESH_ARRAY_GROUP_MEMBERS, static_cast<int>(index), mesh.groups[index].members);
  }
  writer->WritesDone();
  check(writer->Finish());
  return answer.mesh().name();
}

void hold(pb::Scene& scene, const char* name, const char* on, const char* axes) {
  pb::Support* support = scene.add_supports();
  support->set_name(name);
  support->add_on(on);
  pb::Components* held = support->mutable_displacement();
  if (std::strchr(axes, 'x')) held->set_x(0.0);
  if (std::strchr(axes, 'y')) held->set_y(0.0);
  if (std::strchr(axes, 'z')) held->set_z(0.0);
}

pb::Scene scene(const std::string& mesh) {
  pb::Scene scene;
  scene.set_name("hertz-sphere");
  scene.set_mesh(mesh);
  pb::Material* material = scene.add_materials();
  material->set_group("body");
  material->mutable_linear_elastic()->set_shear_modulus(1.0);
  material->mutable_linear_elastic()->set_poisson_ratio(0.5);
  hold(scene, "base", "z0", "xyz");
  hold(scene, "symmetry-x", "x0", "x");
  hold(scene, "symmetry-y", "y0", "y");
  pb::Obstacle* ball = scene.add_obstacles();
  ball->set_name("ball");
  ball->add_on("z1");
  auto* sphere = ball->mutable_shape()->mutable_sphere();
  for (double x : {0.0, 0.0, 1.0}) sphere->add_centre(x);
  sphere->set_radius(1.0);
  scene.mutable_solver()->set_tolerance(1e-10);
  return scene;
}

int run(const std::string& server, const std::string& path) {
  const auto channel = grpc::CreateChannel(server, grpc::InsecureChannelCredentials());
  const auto meshes = pb::MeshService::NewStub(channel);
  const auto sessions = pb::SessionService::NewStub(channel);
  const std::string id = "cpp-" + std::to_string(std::random_device{}());

  pb::CreateSessionRequest create;
  *create.mutable_scene() = scene(upload(*meshes, read_msh(path), id));
  create.set_session_id(id);
  pb::CreateSessionResponse created;
  grpc::ClientContext creating;
  creating.AddMetadata(route, id);
  check(sessions->CreateSession(&creating, create, &created));

  grpc::ClientContext solving;
  solving.AddMetadata(route, id);
  const auto stream = sessions->Solve(&solving);
  pb::SolveRequest open;
  open.mutable_open()->set_session(created.session().name());
  open.mutable_open()->add_fields(pb::FIELD_NAME_DISPLACEMENT);
  stream->Write(open);
  pb::SolveRequest update;
  update.mutable_load_step()->set_sequence(1);
  pb::ObstacleTarget* target = update.mutable_load_step()->mutable_step()->add_obstacles();
  target->set_name("ball");
  for (double x : {0.0, 0.0, -0.05}) target->add_translation(x);
  stream->Write(update);
  stream->WritesDone();  // no update follows: the stream ends with the last result

  pb::SolveResponse response;
  double largest = 0.0;
  while (stream->Read(&response)) {
    if (response.has_update_rejected()) {
      throw std::runtime_error(response.update_rejected().status().message());
    }
    if (response.has_step_finished()) {
      const pb::StepReport& report = response.step_finished().report();
      const auto& force = report.obstacles().at("ball").force();
      std::cout << pb::Termination_Name(report.termination()) << " force " << force[0] << " "
                << force[1] << " " << force[2] << std::endl;
    }
    if (response.has_field()) {  // slices of doubles, little-endian
      const std::string& data = response.field().data();
      for (size_t at = 0; at + sizeof(double) <= data.size(); at += sizeof(double)) {
        double value;
        std::memcpy(&value, data.data() + at, sizeof value);
        largest = std::max(largest, std::abs(value));
      }
    }
  }
  check(stream->Finish());
  std::cout << "largest displacement " << largest << std::endl;

  pb::DeleteSessionRequest remove;
  remove.set_name(created.session().name());
  pb::DeleteSessionResponse removed;
  grpc::ClientContext removing;
  removing.AddMetadata(route, id);
  check(sessions->DeleteSession(&removing, remove, &removed));
  return 0;
}

int main(int count, char** words) {
  const std::string server = count > 1 ? words[1] : "127.0.0.1:50051";
  const std::string mesh = count > 2 ? words[2] : "../examples/meshes/indent_l1.msh";
  try {
    std::cout.precision(12);
    return run(server, mesh);
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << std::endl;
    return 1;
  }
}
