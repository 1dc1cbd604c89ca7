// Traces the rays of 'brdfc-bench --study rays --out DIR' with Embree.
//
// compare DIR prints one line per query, first with Embree's fast tests of triangles, which leak at edges, then with its
// robust ones: name of the query and of the tests, rays, rays per second on one thread and on all threads, rays whose
// answer is that of brdfc, and nearest-hit rays that miss. The layout of DIR/rays.bin is that of Dump::rays in
// studies/src/rays/dump.rs.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace {

using Bytes = std::vector<char>;

// Runs, of which the fastest counts.
constexpr int runs = 5;
// Rays per batch of a thread.
constexpr size_t chunk = 4096;
// Tolerance of distances: the coordinates of a repeated mesh are this coarse.
constexpr float tolerance = 1e-4f;
// Offset by which ray ends are moved on, because the last triangles lie on them.
constexpr float margin = 1e-4f;

struct Ray {
    float origin[3], direction[3], end;
};

[[noreturn]] void fail(const std::string& what) {
    std::fprintf(stderr, "compare: %s\n", what.c_str());
    std::exit(1);
}

Bytes read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(path + ": cannot read");
    return Bytes(std::istreambuf_iterator<char>(file), {});
}

template <class T>
T number(const Bytes& bytes, size_t at) {
    T value;
    if (at + sizeof value > bytes.size()) fail("a file is too short");
    std::memcpy(&value, &bytes[at], sizeof value);
    return value;
}

// Copies the mesh of a PLY file, as brdfc writes it, into a scene.
RTCScene load(RTCDevice device, RTCSceneFlags flags, const Bytes& ply) {
    const std::string end = "end_header\n";
    const auto found = std::search(ply.begin(), ply.end(), end.begin(), end.end());
    if (found == ply.end()) fail("mesh.ply: no header");
    const std::string header(ply.begin(), found);
    const auto count = [&](const std::string& element) -> size_t {
        const auto at = header.find("element " + element + " ");
        if (at == std::string::npos) fail("mesh.ply: no element " + element);
        return std::stoul(header.substr(at + element.size() + 9));
    };
    const size_t vertices = count("vertex"), faces = count("face");
    const size_t start = found - ply.begin() + end.size();
    if (ply.size() != start + 12 * vertices + 13 * faces) fail("mesh.ply: wrong length");
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* points = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
    std::memcpy(points, &ply[start], 12 * vertices);
    auto* corners =
        static_cast<char*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, faces));
    for (size_t k = 0; k < faces; ++k) std::memcpy(corners + 12 * k, &ply[start + 12 * vertices + 13 * k + 1], 12);
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    return scene;
}

RTCRay prepared(const Ray& ray) {
    RTCRay made = {};
    made.org_x = ray.origin[0], made.org_y = ray.origin[1], made.org_z = ray.origin[2];
    made.dir_x = ray.direction[0], made.dir_y = ray.direction[1], made.dir_z = ray.direction[2];
    made.tfar = ray.end + margin;
    made.mask = ~0u;
    return made;
}

float nearest(RTCScene scene, const Ray& ray) {
    RTCRayHit query = {};
    query.ray = prepared(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &query);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &query);
#endif
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<float>::infinity() : query.ray.tfar;
}

float blocked(RTCScene scene, const Ray& ray) {
    RTCRay query = prepared(ray);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &query);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &query);
#endif
    return query.tfar < 0 ? 1.0f : 0.0f;
}

// Seconds of the fastest run with this number of threads.
double seconds(unsigned threads, size_t rays, const std::function<void(size_t, size_t)>& trace) {
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        std::atomic<size_t> next = 0;
        const auto work = [&] {
            for (size_t first; (first = next.fetch_add(chunk)) < rays;) trace(first, std::min(first + chunk, rays));
        };
        std::vector<std::thread> others;
        for (unsigned k = 1; k < threads; ++k) others.emplace_back(work);
        work();
        for (auto& other : others) other.join();
        best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return best;
}

template <class Query>
void compare(const std::string& name, const Query& query, const std::vector<Ray>& rays,
             const std::vector<float>& expected) {
    std::vector<float> answers(rays.size());
    const auto trace = [&](size_t first, size_t end) {
        for (size_t k = first; k < end; ++k) answers[k] = query(rays[k]);
    };
    const double one = seconds(1, rays.size(), trace);
    const double all = seconds(std::max(1u, std::thread::hardware_concurrency()), rays.size(), trace);
    size_t agree = 0, misses = 0;
    for (size_t k = 0; k < rays.size(); ++k) {
        // Infinite answers have no difference.
        agree += answers[k] == expected[k] || std::fabs(answers[k] - expected[k]) <= tolerance;
        misses += std::isinf(answers[k]);
    }
    std::printf("%s %zu %.0f %.0f %zu %zu\n", name.c_str(), rays.size(), rays.size() / one, rays.size() / all, agree,
                misses);
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) fail("usage: compare DIR");
    const std::string folder = arguments[1];
    const Bytes bytes = read(folder + "/rays.bin");
    const size_t counts[2] = {number<uint32_t>(bytes, 0), number<uint32_t>(bytes, 4)};
    const size_t all = counts[0] + counts[1];
    if (bytes.size() != 8 + 32 * all) fail("rays.bin: wrong length");
    RTCDevice device = rtcNewDevice(nullptr);
    if (!device) fail("Embree gives no device");
    const Bytes ply = read(folder + "/mesh.ply");
    for (const RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST}) {
        const std::string tests = flags == RTC_SCENE_FLAG_NONE ? " fast" : " robust";
        RTCScene scene = load(device, flags, ply);
        for (size_t kind = 0, first = 0; kind < 2; first += counts[kind++]) {
            std::vector<Ray> rays(counts[kind]);
            std::vector<float> expected(counts[kind]);
            std::memcpy(rays.data(), bytes.data() + 8 + 28 * first, 28 * rays.size());
            std::memcpy(expected.data(), bytes.data() + 8 + 28 * all + 4 * first, 4 * expected.size());
            if (kind == 0) {
                compare("nearest" + tests, [&](const Ray& ray) { return nearest(scene, ray); }, rays, expected);
            } else {
                compare("any" + tests, [&](const Ray& ray) { return blocked(scene, ray); }, rays, expected);
            }
        }
        rtcReleaseScene(scene);
    }
    rtcReleaseDevice(device);
}
