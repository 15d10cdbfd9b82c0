// Puts a layer behind what a pixel gathered.
void gather(ivec2 pixel, Layer layer) {
    Gathered gathered = load_gathered(pixel);
    put_behind(gathered, layer);
    imageStore(front, ivec3(pixel, 0), vec4(gathered.rgb, gathered.through.r));
    if (TINTED) {
        imageStore(front, ivec3(pixel, THROUGH), vec4(gathered.through, 0.0));
    }
}
