// SPDX-License-Identifier: MIT
#include "import/gltf/gltf_draco.h"

#include <assert.h>
#include <cstdio>
#include <cstring>
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <exception>
#include <memory>
#include <new>

struct stp_draco_mesh {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace
{
// Limits of what a small file may claim; large flat grids need less than 0.1 bits a face.
const uint64_t CLAIMS_ALWAYS_ALLOWED = uint64_t(1) << 16;
const uint64_t CLAIMS_PER_BYTE = 256;

const draco::PointAttribute* find_attribute(const stp_draco_mesh* mesh, uint32_t id)
{
    return mesh->mesh->GetAttributeByUniqueId(id);
}

template <typename T> float value_at(const unsigned char* bytes, uint32_t component)
{
    T value;
    std::memcpy(&value, bytes + component * sizeof(T), sizeof(T));
    return static_cast<float>(value);
}

float read_value(draco::DataType type, const unsigned char* bytes, uint32_t component)
{
    switch (type) {
    case draco::DT_INT8:
        return value_at<int8_t>(bytes, component);
    case draco::DT_UINT8:
    case draco::DT_BOOL:
        return value_at<uint8_t>(bytes, component);
    case draco::DT_INT16:
        return value_at<int16_t>(bytes, component);
    case draco::DT_UINT16:
        return value_at<uint16_t>(bytes, component);
    case draco::DT_INT32:
        return value_at<int32_t>(bytes, component);
    case draco::DT_UINT32:
        return value_at<uint32_t>(bytes, component);
    case draco::DT_INT64:
        return value_at<int64_t>(bytes, component);
    case draco::DT_UINT64:
        return value_at<uint64_t>(bytes, component);
    case draco::DT_FLOAT32:
        return value_at<float>(bytes, component);
    case draco::DT_FLOAT64:
        return value_at<double>(bytes, component);
    default:
        return 0.0f;
    }
}

// Skips the header and the metadata. @return whether both could be read
bool skip_header(draco::DecoderBuffer* buffer, draco::DracoHeader* header)
{
    if (!draco::PointCloudDecoder::DecodeHeader(buffer, header).ok()) {
        return false;
    }
    const auto version = static_cast<uint16_t>(
        DRACO_BITSTREAM_VERSION(header->version_major, header->version_minor));
    buffer->set_bitstream_version(version);
    if (version < DRACO_BITSTREAM_VERSION(1, 3) || (header->flags & METADATA_FLAG_MASK) == 0) {
        return true;
    }
    draco::GeometryMetadata metadata;
    return draco::MetadataDecoder().DecodeGeometryMetadata(buffer, &metadata);
}

// The sum of all counts by which libdraco allocates memory before it decodes; 0 if they cannot be
// read, which is reported when decoding.
uint64_t find_claims(draco::DecoderBuffer* buffer)
{
    draco::DracoHeader header;
    if (!skip_header(buffer, &header)) {
        return 0;
    }
    uint16_t version = buffer->bitstream_version();
    bool connected = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
    const uint16_t second = DRACO_BITSTREAM_VERSION(2, 0), last = DRACO_BITSTREAM_VERSION(2, 2);
    bool varint = version >= (connected ? second : last);
    int count = connected && version < last ? 3 : 2;
    uint8_t traversal = 0;
    uint64_t sum = 0;
    bool good = !connected || buffer->Decode(&traversal);
    for (int i = 0; i < count && good; ++i) {
        uint32_t value = 0;
        good = varint ? draco::DecodeVarint(&value, buffer) : buffer->Decode(&value);
        sum += value;
    }
    return good ? sum : 0;
}

// Whether all faces and all mapped values exist, which libdraco does not promise for damaged data.
bool is_consistent(const draco::Mesh& mesh)
{
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
        for (size_t c = 0; c < 3; ++c) {
            if (mesh.face(f)[c].value() >= mesh.num_points()) {
                return false;
            }
        }
    }
    for (int i = 0; i < mesh.num_attributes(); ++i) {
        const draco::PointAttribute* attribute = mesh.attribute(i);
        size_t stride = static_cast<size_t>(attribute->byte_stride());
        size_t needed = static_cast<size_t>(draco::DataTypeLength(attribute->data_type())) *
                        static_cast<size_t>(attribute->num_components());
        if (attribute->buffer() == nullptr || attribute->data_type() <= draco::DT_INVALID ||
            stride < needed) {
            return false;
        }
        size_t data_size = attribute->buffer()->data_size();
        for (draco::PointIndex p(0); p < mesh.num_points(); ++p) {
            if (!attribute->is_mapping_identity() && p.value() >= attribute->indices_map_size()) {
                return false;
            }
            size_t value = attribute->mapped_index(p).value();
            int64_t offset = attribute->byte_offset();
            if (offset < 0 || value >= attribute->size() ||
                static_cast<size_t>(offset) + value * stride + needed > data_size) {
                return false;
            }
        }
    }
    return true;
}
} // namespace

stp_draco_result stp_draco_decode(const void* bytes, size_t size, stp_draco_mesh** mesh,
                                  char reason[80])
{
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(static_cast<const char*>(bytes), size);
        uint64_t claims = find_claims(&buffer);
        if (claims > CLAIMS_ALWAYS_ALLOWED && claims / CLAIMS_PER_BYTE > size) {
            std::snprintf(reason, 80, "%llu faces and points are claimed in %zu bytes",
                          static_cast<unsigned long long>(claims), size);
            return STP_DRACO_DAMAGED;
        }
        buffer.Init(static_cast<const char*>(bytes), size);
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok()) {
            std::snprintf(reason, 80, "%s", decoded.status().error_msg());
            return STP_DRACO_DAMAGED;
        }
        std::unique_ptr<draco::Mesh> made = std::move(decoded).value();
        if (made == nullptr || !is_consistent(*made)) {
            std::snprintf(reason, 80, "indices past the end");
            return STP_DRACO_DAMAGED;
        }
        assert(made->num_faces() == 0 || made->num_points() > 0);
        *mesh = new stp_draco_mesh{std::move(made)};
        return STP_DRACO_OK;
    } catch (const std::bad_alloc&) {
        return STP_DRACO_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        std::snprintf(reason, 80, "%s", error.what());
        return STP_DRACO_DAMAGED;
    }
}

void stp_draco_destroy(stp_draco_mesh* mesh)
{
    delete mesh;
}

uint32_t stp_draco_point_count(const stp_draco_mesh* mesh)
{
    return mesh->mesh->num_points();
}

uint32_t stp_draco_face_count(const stp_draco_mesh* mesh)
{
    return mesh->mesh->num_faces();
}

void stp_draco_indices(const stp_draco_mesh* mesh, uint32_t* out)
{
    for (draco::FaceIndex f(0); f < mesh->mesh->num_faces(); ++f) {
        for (size_t c = 0; c < 3; ++c) {
            assert(mesh->mesh->face(f)[c].value() < mesh->mesh->num_points());
            *out++ = mesh->mesh->face(f)[c].value();
        }
    }
}

uint32_t stp_draco_component_count(const stp_draco_mesh* mesh, uint32_t id)
{
    const draco::PointAttribute* attribute = find_attribute(mesh, id);
    return attribute != nullptr ? static_cast<uint32_t>(attribute->num_components()) : 0;
}

void stp_draco_values(const stp_draco_mesh* mesh, uint32_t id, float* out)
{
    const draco::PointAttribute* attribute = find_attribute(mesh, id);
    uint32_t components = static_cast<uint32_t>(attribute->num_components());
    for (draco::PointIndex p(0); p < mesh->mesh->num_points(); ++p) {
        const unsigned char* bytes = attribute->GetAddressOfMappedIndex(p);
        for (uint32_t c = 0; c < components; ++c) {
            *out++ = read_value(attribute->data_type(), bytes, c);
        }
    }
}
