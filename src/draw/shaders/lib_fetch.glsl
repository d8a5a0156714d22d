// Reads words of scene data by address. There are PAGE_COUNT pages of 2^PAGE_SHIFT words.
#include "interface.h"

layout(std430, binding = BINDING_PAGES + 0) readonly buffer Page0 { uint page0[]; };
#if PAGE_COUNT > 1
layout(std430, binding = BINDING_PAGES + 1) readonly buffer Page1 { uint page1[]; };
#endif
#if PAGE_COUNT > 2
layout(std430, binding = BINDING_PAGES + 2) readonly buffer Page2 { uint page2[]; };
layout(std430, binding = BINDING_PAGES + 3) readonly buffer Page3 { uint page3[]; };
#endif
#if PAGE_COUNT > 4
layout(std430, binding = BINDING_PAGES + 4) readonly buffer Page4 { uint page4[]; };
layout(std430, binding = BINDING_PAGES + 5) readonly buffer Page5 { uint page5[]; };
layout(std430, binding = BINDING_PAGES + 6) readonly buffer Page6 { uint page6[]; };
layout(std430, binding = BINDING_PAGES + 7) readonly buffer Page7 { uint page7[]; };
#endif

uint fetch(uint address)
{
#if PAGE_COUNT == 1
    return page0[address];
#else
    uint at = address & ((1u << PAGE_SHIFT) - 1u);
    switch (address >> PAGE_SHIFT) {
    case 0u:
        return page0[at];
#if PAGE_COUNT > 2
    case 2u:
        return page2[at];
    case 3u:
        return page3[at];
#endif
#if PAGE_COUNT > 4
    case 4u:
        return page4[at];
    case 5u:
        return page5[at];
    case 6u:
        return page6[at];
    case 7u:
        return page7[at];
#endif
    default:
        return page1[at];
    }
#endif
}

float fetch_float(uint address)
{
    return uintBitsToFloat(fetch(address));
}

vec3 fetch_vec3(uint address)
{
    return vec3(fetch_float(address), fetch_float(address + 1u), fetch_float(address + 2u));
}
