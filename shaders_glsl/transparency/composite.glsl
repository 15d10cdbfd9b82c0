// Compositing of sorted layers, one way for all techniques: equal layers give equal bits.

// Puts a layer behind what is gathered so far (Porter and Duff 1984, *over*; the alpha of `front` is what it lets
// through). One function for all that composites, and exact, so that equal layers give equal bits.
void put_behind(inout vec4 front, vec4 layer) {
    precise vec3 rgb = front.rgb + front.a * layer.rgb;
    precise float through = front.a * (1.0 - layer.a);
    front = vec4(rgb, through);
}

// The whole over what is opaque.
vec4 over_opaque(vec4 front, vec4 opaque) {
    precise vec3 rgb = front.rgb + front.a * opaque.rgb;
    precise float alpha = 1.0 - front.a * (1.0 - opaque.a);
    return vec4(rgb, alpha);
}
