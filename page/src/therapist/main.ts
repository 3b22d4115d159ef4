import { mount } from "svelte";
import "../theme.css";
import { applyTheme } from "../theme";
import Therapist from "./Therapist.svelte";

applyTheme();
mount(Therapist, { target: document.querySelector("#page")! });
