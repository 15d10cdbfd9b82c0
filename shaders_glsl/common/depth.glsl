// Depth convention: reversed. 1 on the near plane, 0 at infinity. The host's twin is `scene::depth`.
const float DEPTH_CLEAR = 0.0;
