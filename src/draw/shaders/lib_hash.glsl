// The same noise as on the CPU (src/raster/splats_frame.h, src/base/math/rng.h, src/select/select.h):
// hashing keeps the same pixels.

// Whether a fragment of a splat with holes is drawn.
bool has_fragment(uint coverage, uint index, ivec2 place)
{
    uint h = index * 0x9E3779B1u + 0x7F4A7C15u;
    h ^= uint(place.x) * 0x85EBCA6Bu + uint(place.y) * 0xC2B2AE35u;
    h ^= h >> 15;
    h *= 0x2C1B3C6Du;
    h ^= h >> 13;
    h *= 0x297A2D39u;
    return (h >> 24) < coverage + (coverage >> 7);
}

// Whether a triangle belongs to the drawn share of its mesh (stp_draw_keeps).
bool keeps(uint index, float share)
{
    uint h = index * 0x9E3779B1u;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h ^= h >> 13;
    return float(h >> 8) < share * 16777216.0;
}

// 64-bit integers: x is the low half.
uvec2 multiply(uvec2 a, uvec2 b)
{
    uint high, low;
    umulExtended(a.x, b.x, high, low);
    return uvec2(low, high + a.x * b.y + a.y * b.x);
}

uvec2 add(uvec2 a, uvec2 b)
{
    uint carry;
    uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}

uvec2 fold(uvec2 a, int shift) // a ^ a >> shift
{
    return a ^ uvec2((a.x >> shift) | (a.y << (32 - shift)), a.y >> shift);
}

// stp_rng_hash
uvec2 random_bits(uvec2 seed, uvec2 index)
{
    uvec2 z = add(seed, multiply(add(index, uvec2(1u, 0u)), uvec2(0x7F4A7C15u, 0x9E3779B9u)));
    z = multiply(fold(z, 30), uvec2(0x1CE4E5B9u, 0xBF58476Du));
    z = multiply(fold(z, 27), uvec2(0x133111EBu, 0x94D049BBu));
    return fold(z, 31);
}

// 0..1
float noise(uvec2 seed, ivec2 pixel)
{
    uvec2 bits = random_bits(seed, uvec2(pixel));
    return float(bits.y >> 8) * (1.0 / 16777216.0);
}
