// The surface of a run: drag turns it, wheel zooms, right drag moves; arrows, plus and minus do it by keys.
class View {
  constructor(place, surface) {
    this.surface = surface;
    this.index = 0;
    this.corners = numbers(surface.corners, "i4");
    this.faces = numbers(surface.faces, "i4");
    this.edges = numbers(surface.edges, "i4");
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setClearColor(0xfafbfd);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(24, 4 / 3, 0.05, 200);
    this.place = place;
    place.append(this.renderer.domElement);
    this.addBody();
    this.addObstacles();
    this.scene.add(new THREE.AmbientLight(0xffffff, 1.5), this.camera);
    const lamp = new THREE.DirectionalLight(0xffffff, 1.8);
    lamp.position.set(-0.5, 0.9, 1);
    this.camera.add(lamp);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.render());
    this.home();
    this.listen();
    this.choose(0);
    new ResizeObserver(() => this.fit()).observe(place);
    this.fit();
  }

  addBody() {
    const count = this.corners.length;
    const geometry = this.geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    const skin = new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.body = new THREE.Mesh(geometry, skin);
    const lines = this.lines = new THREE.BufferGeometry();
    lines.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * this.edges.length), 3));
    this.net = new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.45 }));
    for (const part of [this.body, this.net]) part.frustumCulled = false;
    this.scene.add(this.body, this.net);
  }

  addObstacles() {
    this.obstacles = this.surface.obstacles.map(one => {
      const points = numbers(one.points, "f8"), corners = numbers(one.corners, "i4");
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(points), 3));
      geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(corners), 1));
      geometry.computeVertexNormals();
      const skin = new THREE.MeshLambertMaterial({ color: 0xb4bfce, side: THREE.FrontSide, transparent: true, opacity: 0.55, depthWrite: false });
      const mesh = new THREE.Mesh(geometry, skin);
      mesh.matrixAutoUpdate = false;
      mesh.renderOrder = 1;
      this.scene.add(mesh);
      return { mesh, places: one.places };
    });
  }

  showObstacles(shown) {
    for (const one of this.obstacles) one.mesh.visible = shown;
    this.render();
  }

  home() {
    const up = new THREE.Vector3(...this.surface.up).normalize();
    const aside = new THREE.Vector3(1, 0, 0);
    if (Math.abs(up.x) > 0.9) aside.set(0, 1, 0);
    const second = new THREE.Vector3().crossVectors(up, aside).normalize();
    const first = new THREE.Vector3().crossVectors(second, up).normalize();
    this.camera.up.copy(up);
    this.camera.position.copy(first).multiplyScalar(0.45).addScaledVector(second, -0.8).addScaledVector(up, 0.4).normalize().multiplyScalar(6.4);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
    this.render();
  }

  fit() {
    const { clientWidth, clientHeight } = this.place;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  choose(number) {
    this.field = this.surface.fields[number];
    this.table = numbers(this.field.colours, "u2");
    this.show(this.index);
  }

  show(index) {
    this.index = index;
    const raw = numbers(this.surface.positions[index], "u2"), field = this.field;
    const place = this.geometry.attributes.position.array, colour = this.geometry.attributes.color.array;
    const values = field ? numbers(field.frames[index], "u2") : null;
    for (let corner = 0; corner < this.corners.length; corner++) {
      const node = this.corners[corner];
      for (let axis = 0; axis < 3; axis++) place[3 * corner + axis] = raw[3 * node + axis] / 32767.5 - 1;
      if (!values) continue;
      const value = values[field.nodal ? node : this.faces[Math.floor(corner / 3)]];
      const step = 3 * Math.round(value / 65535 * 255);
      for (let axis = 0; axis < 3; axis++) colour[3 * corner + axis] = (this.table[step + axis] / 255) ** 2.2;
    }
    const net = this.lines.attributes.position.array;
    for (let end = 0; end < this.edges.length; end++)
      for (let axis = 0; axis < 3; axis++) net[3 * end + axis] = raw[3 * this.edges[end] + axis] / 32767.5 - 1;
    this.geometry.attributes.position.needsUpdate = this.geometry.attributes.color.needsUpdate = true;
    this.lines.attributes.position.needsUpdate = true;
    for (const { mesh, places } of this.obstacles) {
      mesh.matrix.set(...places[Math.min(index, places.length - 1)]);
      mesh.matrixWorldNeedsUpdate = true;
    }
    this.render();
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }

  turn(across, upward, nearer) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const up = this.camera.up, right = new THREE.Vector3().crossVectors(up, offset).normalize();
    offset.applyAxisAngle(up, across);
    const tilted = offset.clone().applyAxisAngle(right, upward);
    if (Math.abs(tilted.clone().normalize().dot(up)) < 0.995) offset.copy(tilted);
    this.camera.position.copy(this.controls.target).add(offset.multiplyScalar(nearer));
    this.controls.update();
    this.render();
  }

  listen() {
    this.place.addEventListener("keydown", event => {
      const way = { ArrowLeft: [-0.15, 0, 1], ArrowRight: [0.15, 0, 1], ArrowUp: [0, -0.15, 1], ArrowDown: [0, 0.15, 1], "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1.1] }[event.key];
      if (way) { event.preventDefault(); this.turn(...way); }
    });
  }
}
