// Reads triangles and their corners from a mesh's clusters.
#include "lib_item.glsl"

struct triangle_place {
    uint mesh, cluster; // addresses
    uvec3 corner;       // vertices in the cluster
    uint lighting;
};

triangle_place find_triangle(uint mesh, uint cluster, uint local)
{
    triangle_place t;
    uint word = fetch(mesh + fetch(cluster + CLUSTER_TRIANGLES) + local);
    t.mesh = mesh;
    t.cluster = cluster;
    t.corner = uvec3(word, word >> 10, word >> 20) & 1023u;
    t.lighting = word >> 30;
    return t;
}

vec3 corner_position(const triangle_place t, uint vertex)
{
    return fetch_vec3(t.mesh + fetch(t.cluster + CLUSTER_POSITIONS) + 3u * vertex);
}

bool has_texcoords(const triangle_place t, uint set)
{
    return fetch(t.cluster + CLUSTER_TEXCOORDS + set) != 0u;
}

vec2 corner_texcoord(const triangle_place t, uint set, uint vertex)
{
    uint at = t.mesh + fetch(t.cluster + CLUSTER_TEXCOORDS + set) + 2u * vertex;
    return vec2(fetch_float(at), fetch_float(at + 1u));
}

vec4 corner_color(const triangle_place t, uint vertex)
{
    uint at = t.mesh + fetch(t.cluster + CLUSTER_COLORS) + 2u * vertex;
    return vec4(unpackUnorm2x16(fetch(at)), unpackUnorm2x16(fetch(at + 1u)));
}

vec3 corner_normal(const triangle_place t, uint vertex)
{
    int code = int(fetch(t.mesh + fetch(t.cluster + CLUSTER_NORMALS) + vertex));
    vec2 uv = vec2(float(bitfieldExtract(code, 0, 16)), float(bitfieldExtract(code, 16, 16)));
    return decode_octahedral(uv / 32767.0, 1.0);
}
